// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <vector>

#include "libhybrid/fixes/fix.h"
#include "libhybrid/landmarks/contribution.h"

namespace HYBRID_API hybrid {

/// What fixes are taken for is relative: a run of biased ones may be good, and the map off by their
/// bias, which half-steps do not find out. Returns the poses, landmarks and lasting errors of the
/// map as they are then, for the longest run of biased fixes; nothing where fixes are good for
/// longer than that run.
std::optional<Values> shift_by_bias(const std::vector<FixEntry>& fixes, const MapView& map);

/// Poses of keyframes as the fixes of the receiver that has most have them, in a log without
/// odometry. The heading is that of two antennas, or of the way ahead.
Values poses_at_fixes(const std::vector<FixEntry>& fixes, const Eigen::Isometry3d& T_datum_map,
                      bool is_3d);

}  // namespace hybrid
