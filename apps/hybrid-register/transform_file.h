// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "libhybrid/geometry/se3.h"

namespace hybrid {

/// Reads a 4x4 matrix, row by row. Throws Error for a missing or malformed file, or a matrix that
/// is not a rigid motion.
SE3 read_transform(const std::string& path);

/// The matrix as text of the same form, with all digits.
std::string transform_text(const SE3& T);

}  // namespace hybrid
