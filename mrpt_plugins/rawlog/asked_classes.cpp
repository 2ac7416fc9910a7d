// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/asked_classes.h"

#include <fmt/format.h>
#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/obs/registerAllClasses.h>

#include <algorithm>

#include "libhybrid/core/error.h"

namespace hybrid {

std::string without_namespace(const std::string& class_name) {
  const std::size_t colon = class_name.rfind(':');
  return colon == std::string::npos ? class_name : class_name.substr(colon + 1);
}

void register_mrpt_classes() {
  mrpt::obs::registerAllClasses_mrpt_obs();
  mrpt::maps::registerAllClasses_mrpt_maps();
}

AskedClasses::AskedClasses(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const mrpt::rtti::TRuntimeClassId* id = mrpt::rtti::findRegisteredClass(name);
    if (id == nullptr || !id->derivedFrom(CLASS_ID(mrpt::obs::CObservation)) ||
        !id->ptrCreateObject) {
      throw Error(fmt::format("'{}' is not a registered class of observations", name));
    }
    ids_.push_back(id);
  }
}

bool AskedClasses::contain(const std::string& class_name) const {
  const auto* id = ids_.empty() ? nullptr : mrpt::rtti::findRegisteredClass(class_name);
  return id != nullptr && std::find(ids_.begin(), ids_.end(), id) != ids_.end();
}

}  // namespace hybrid
