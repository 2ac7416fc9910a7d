// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/evaluation/reliability.h"
#include "mrpt_plugins/evaluation/trajectory_metrics.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// steps.png: solver time per keyframe (ms, logarithmic) with median and 95th percentile.
Image steps_image(const std::vector<StepRecord>& steps, const std::string& title);

/// Position error (m, logarithmic) over time (s since the first pose), without and with rigid
/// alignment, for the estimate and, if it has poses, for dead reckoning. `times` has one entry per
/// pair of the estimate; dead reckoning pairs, if any, belong to the same times. If fewer than half
/// of the times are later than the one before, the axis numbers the pairs instead.
Image error_image(const std::vector<double>& times, const std::vector<PosePair>& estimate,
                  const std::vector<PosePair>& dead_reckoning, const std::string& title);

/// Texts of a reliability diagram about its probabilities.
struct ReliabilityNames {
  const char* things = "objects";
  const char* stated = "stated probability of a class";
  const char* observed = "observed frequency of that class";
};
inline constexpr ReliabilityNames kOfClosures{"loop closures", "stated inlier probability",
                                              "observed frequency of inliers"};

/// Reliability diagram: predicted probability against observed frequency with 95 % intervals
/// (Wilson) and the number of predictions per bin. Calibrated probabilities are on the diagonal.
Image reliability_image(const Calibration& calibration, const std::string& title,
                        const ReliabilityNames& names = {});

}  // namespace hybrid
