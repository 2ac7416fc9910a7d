// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/core/variable.h"

namespace HYBRID_API hybrid {

/// What a map is of, as far as the steps of its poses depend on it.
struct MapKind {
  VariableKind pose = VariableKind::kVector;  ///< of its poses, once there is one
  bool has_points = false;
};

}  // namespace hybrid
