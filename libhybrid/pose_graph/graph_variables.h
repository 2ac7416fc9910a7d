// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/core/key.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/variable.h"

namespace HYBRID_API hybrid {

/// Whether a variable is a pose x<id>, or a landmark l<id> of two or three coordinates: files of
/// graphs hold no other.
inline bool is_pose_or_landmark(Key key, VariableType type) {
  if (key.letter() == key_letter::kPose) return is_pose(type);
  return key.letter() == key_letter::kLandmark && type.kind == VariableKind::kVector &&
         (type.dim == 2 || type.dim == 3);
}

}  // namespace hybrid
