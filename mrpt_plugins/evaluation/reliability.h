// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Class probabilities predicted for one object, and its true class.
struct ClassPrediction {
  std::vector<double> probabilities;
  int true_class = 0;
};

/// Predictions with a probability between two bounds.
struct ReliabilityBin {
  double lower = 0, upper = 0;
  std::size_t count = 0;
  double mean_predicted = 0;  ///< mean predicted probability; NaN when empty
  double observed = 0;        ///< fraction of true predictions; NaN when empty
};

/// Calibration of predicted class probabilities.
struct Calibration {
  std::size_t predictions = 0;
  double brier = 0;           ///< mean of sum_c (p_c - [c is true])^2, between 0 and 2
  double log_loss = 0;        ///< mean of -log p(true class), p no less than 1e-15, nats
  double expected_error = 0;  ///< mean |observed - mean_predicted| weighted by the bins' counts
  std::vector<ReliabilityBin> bins;  ///< over every class of every prediction ("is it a c?")
};

/// Calibration over `bins` equal bins of [0, 1]; NaN figures without predictions. Throws
/// std::invalid_argument if a true class has no probability or a probability is not in [0, 1].
Calibration calibration(const std::vector<ClassPrediction>& predictions, int bins = 10);

}  // namespace hybrid
