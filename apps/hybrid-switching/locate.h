// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "apps/hybrid-switching/range_log.h"
#include "libhybrid/core/loss.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/switching/markov.h"

namespace hybrid {

/// Error model of ranges by mode: mode 0 in line of sight, mode 1 delayed by walls.
struct RangeModes {
  std::vector<double> bias;   ///< m
  std::vector<double> sigma;  ///< m
  MarkovChain chain;          ///< from one range to the next of the same anchor
};

/// The path of a robot, by one error model of its ranges.
struct Located {
  std::string method;
  std::vector<double> times;              ///< of the poses [s]
  std::vector<SE2> path;                  ///< in the frame of the anchors
  std::vector<double> non_line_of_sight;  ///< probability for each range; empty without modes
  RangeModes modes;                       ///< as learnt
  int rounds = 0;                         ///< rounds of learning
  double objective = 0;
  double seconds = 0;
};

/// Locates with Gaussian ranges, noise of the log and a robust loss.
Located locate(const RangeLog& log, const std::string& method, Loss loss);

/// Locates with a mode variable for each range and a Markov chain along the ranges of each anchor.
/// Biases, sigmas and chain are learnt from the ranges by expectation-maximisation.
Located locate_with_modes(const RangeLog& log);

/// Distance to each true point at its time [m].
std::vector<double> position_errors(const Located& located, const std::vector<TruePoint>& truth);

}  // namespace hybrid
