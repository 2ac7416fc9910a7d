// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// Appends the sighting of a landmark that the factor is, its position in the frame of the pose; of
/// a bearing-range measurement with the covariance to first order, and nothing if that is singular
/// (at range zero). False if the factor is neither. For SE2 and SE3.
template <class Pose>
bool add_sighting(const ContinuousFactor& factor,
                  std::vector<GraphEdge<typename Pose::Point>>& edges);

}  // namespace hybrid
