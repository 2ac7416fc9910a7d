// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/association/prediction.h"

namespace HYBRID_API hybrid {

/// Joint compatibility branch and bound (Neira and Tardos, IEEE Transactions on Robotics and
/// Automation 17(6), 2001): of the matchings whose innovations, each detection with its own noise,
/// are within the chi-square gate of that probability both one by one and all together, the one
/// with the most pairs, and of these the one of least joint chi-square, which is its cost. The
/// search is exponential where many pairs are ambiguous: after `max_pairs` pairs tried it ends with
/// the best found.
Matching joint_compatibility(const PredictedSightings& predicted,
                             const std::vector<MeasuredPoint>& measured, double gate,
                             int max_pairs = 200000);

}  // namespace hybrid
