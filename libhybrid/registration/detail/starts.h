// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/geometry/se3.h"

namespace hybrid {

/// Starts around a given one, for clouds whose overlap does not show: turned about the centre of
/// the source in fourteen directions, each with the centre where the start puts it and with both
/// centres together; and the start itself with both centres together.
std::vector<SE3> other_starts(const SE3& T_target_source, const Eigen::Vector3d& source_center,
                              const Eigen::Vector3d& target_center);

}  // namespace hybrid
