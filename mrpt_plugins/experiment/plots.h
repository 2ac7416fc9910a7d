// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/experiment/statistics.h"

namespace HYBRID_API hybrid {

/// Joins pictures of equal height side by side.
Image side_by_side(const std::vector<Image>& images);

/// One graph of an experiment: position error, rotation error and time over the rate of false
/// closures (or the variant of the graph), a panel each. Lines are medians over seeds, bands reach
/// from the lower to the upper quartile. Points must be of that graph.
Image comparison_image(const ExperimentPlan& plan, const std::string& graph,
                       const std::vector<PointSummary>& points,
                       const std::vector<std::string>& metrics);

/// One metric of all replays: medians with quartiles, one column per replay and one marker per
/// method.
Image replay_image(const ExperimentPlan& plan, const std::string& metric,
                   const std::vector<PointSummary>& points,
                   const std::vector<std::string>& metrics);

}  // namespace hybrid
