// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "mrpt_plugins/evaluation/trajectory_metrics.h"

namespace HYBRID_API hybrid {

/// Whether a true path can be of the robot that moved as odometry tells; `reckoned` pairs the poses
/// of dead reckoning with the true ones. It cannot where it explains less than half of the variance
/// of the motions that odometry tells, over stretches of 1, 2, 4 ... poses up to a tenth of the
/// log, and differs over the longest ones by more than a quarter of the way, where drift is some
/// percents. Of positions alone, lengths are compared.
/// What moves always alike, or for fewer than 40 poses, tells nothing and counts as possible.
bool may_be_same_motion(const std::vector<PosePair>& reckoned, TruthContent content);

}  // namespace hybrid
