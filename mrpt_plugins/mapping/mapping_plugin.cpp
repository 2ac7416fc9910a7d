// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/mapping_plugin.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "libhybrid/core/error.h"
#include "libhybrid/core/sort_unique.h"

IMPLEMENTS_VIRTUAL_MRPT_OBJECT(MappingPlugin, mrpt::rtti::CObject, hybrid)

namespace hybrid {

bool MappingPlugin::suits(const LogContents& log) const {
  const std::vector<std::string> used = uses();
  return std::any_of(used.begin(), used.end(), [&](const std::string& name) {
    return log.observations.count(without_namespace(name)) != 0;
  });
}

std::vector<std::string> registered_plugins() {
  std::vector<std::string> names;
  for (const auto* id : mrpt::rtti::getAllRegisteredClassesChildrenOf(CLASS_ID(MappingPlugin))) {
    if (id->ptrCreateObject) names.push_back(without_namespace(id->className));
  }
  sort_unique(names);
  return names;
}

std::shared_ptr<MappingPlugin> make_plugin(const std::string& class_name, IniFile& ini) {
  const mrpt::rtti::TRuntimeClassId* found = nullptr;
  for (const auto* id : mrpt::rtti::getAllRegisteredClassesChildrenOf(CLASS_ID(MappingPlugin))) {
    const bool named = class_name == id->className ||
                       without_namespace(class_name) == without_namespace(id->className);
    if (id->ptrCreateObject && named) found = id;
  }
  if (found == nullptr) {
    throw Error(
        fmt::format("{}: [plugins] classes names '{}', which is not a registered mapping "
                    "plugin; registered are: {} (load others with -p)",
                    ini.name(), class_name, fmt::join(registered_plugins(), ", ")));
  }
  auto plugin = std::dynamic_pointer_cast<MappingPlugin>(found->createObject());
  plugin->configure(ini.section(without_namespace(found->className)));
  return plugin;
}

}  // namespace hybrid
