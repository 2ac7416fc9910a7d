// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/geometry/se3.h"

namespace hybrid {

/// Other starts than a given one, for clouds with little overlap: rotated about the centre of the
/// source in fourteen directions, each with that centre unmoved and with the centres of both clouds
/// together; and the given one with both centres together.
std::vector<SE3> other_starts(const SE3& T_target_source, const Eigen::Vector3d& source_center,
                              const Eigen::Vector3d& target_center);

}  // namespace hybrid
