// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/discrete/table.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/switching/markov.h"

namespace HYBRID_API hybrid {

/// The motion of one mode, vector-autoregressive of order p: x_t = B [1; x_{t-1}; ...; x_{t-p}] + e
/// with e of covariance Q.
struct Autoregression {
  Eigen::MatrixXd coefficients;  ///< B, d x (1 + d p)
  Eigen::MatrixXd covariance;    ///< Q, d x d
};

/// A switching system (Fig. 1a): modes with a Markov chain, each of which has its own motion.
struct SwitchingModel {
  MarkovChain chain;
  int order = 0;
  std::vector<Autoregression> motions;  ///< one per mode

  int modes() const { return static_cast<int>(motions.size()); }
};

/// Observations of a system, d x n: a column per instant.
using Series = Eigen::MatrixXd;

/// [1; x_{t-1}; ...; x_{t-p}], for t >= p.
Eigen::VectorXd regressors(const Series& series, int t, int order);

/// The discrete factors of a series under a model, over one mode variable per instant: first the
/// chain, a table per instant, then -log p(x_t | mode, past) for the instants t >= p, whose p
/// predecessors are known. Throws Error if model and series do not fit.
std::vector<Table> switching_tables(const SwitchingModel& model, const Series& series);

/// The mode variable of an instant.
inline DiscreteKey mode_key(int t, int modes) {
  return {Key(key_letter::kMotionMode, static_cast<std::uint64_t>(t)), modes};
}

/// The modes of a series under a model.
struct Labelling {
  std::vector<int> modes;         ///< jointly most probable (Viterbi), one per instant
  Eigen::MatrixXd probabilities;  ///< p(mode | whole series), a column per instant
  double log_likelihood = 0.0;    ///< of the series, summed over all modes
};

/// Viterbi by elimination, posteriors by forward-backward in the same junction tree.
Labelling label(const SwitchingModel& model, const Series& series);

}  // namespace hybrid
