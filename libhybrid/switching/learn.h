// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/switching/autoregression.h"

namespace HYBRID_API hybrid {

/// A stretch of a series with its modes known at every instant.
struct LabelledSeries {
  Series series;
  std::vector<int> modes;
};

/// Priors: p(B, Q) ~ |Q|^(-1/2) exp(-tr(Q^-1 (ridge B B' + q I)) / 2) for a motion, which is worth
/// one observation of variance q, and a Dirichlet prior for the chain.
struct LearnOptions {
  int order = 2;
  double change_prior = 1.0;     ///< counts of every change and start
  double ridge = 1e-3;           ///< information of each coefficient about zero
  double least_variance = 1e-3;  ///< q, as a share of the variance of the series
  int max_rounds = 200;          ///< of expectation-maximisation
  double relative_gain = 1e-7;   ///< of the log posterior, at which it has converged
};

/// The most probable parameters given the modes: counts and regularised least squares. Throws Error
/// for labels outside 0 .. modes - 1, stretches that differ in width, or a mode never seen.
SwitchingModel learn_from_labels(const std::vector<LabelledSeries>& stretches, int modes,
                                 const LearnOptions& options = {});

/// The result of expectation-maximisation.
struct EmResult {
  SwitchingModel model;
  /// log p(series, parameters) up to a constant, before every round and after the last; never
  /// falls.
  std::vector<double> log_posteriors;
  bool converged = false;
};

/// Expectation-maximisation from a first guess, modes unknown: probabilities of the modes and of
/// their changes by forward-backward, then parameters as in learn_from_labels with these as
/// weights. The order is that of the guess.
EmResult learn_without_labels(const std::vector<Series>& stretches, const SwitchingModel& guess,
                              const LearnOptions& options = {});

/// A first guess for learn_without_labels: instants are sorted into modes of equal size by the mean
/// of the first value of the series over a window of 2 `half_window` + 1 instants, mode 0 the
/// least.
SwitchingModel guess_by_level(const std::vector<Series>& stretches, int modes, int half_window,
                              const LearnOptions& options = {});

}  // namespace hybrid
