// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/rtti/CObject.h>

#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// The name of a class as MRPT registers it, without what stands before its last colon.
std::string without_namespace(const std::string& class_name);

/// Makes the classes of MRPT known by name: the linker drops libraries that are used in no other
/// way.
void register_mrpt_classes();

/// Classes of observations that are wanted as MRPT objects.
class AskedClasses {
 public:
  /// Names with or without namespace. Throws Error for one that no library has registered, or that
  /// is no class of observations.
  explicit AskedClasses(const std::vector<std::string>& names);

  bool contain(const std::string& class_name) const;

 private:
  std::vector<const mrpt::rtti::TRuntimeClassId*> ids_;
};

}  // namespace hybrid
