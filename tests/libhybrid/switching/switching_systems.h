// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/switching/learn.h"
#include "tests/support/random.h"

namespace hybrid::testing {

/// A mode drawn from probabilities.
inline int draw(Random& random, const Eigen::VectorXd& p) {
  double u = random.uniform();
  for (int i = 0; i + 1 < p.size(); ++i) {
    if (u < p[i]) return i;
    u -= p[i];
  }
  return static_cast<int>(p.size()) - 1;
}

/// Two modes of a plane: a slow turn, and a fast oscillation with less noise.
inline SwitchingModel two_modes(double stay = 0.95) {
  SwitchingModel model;
  model.chain = sticky_chain(2, stay);
  model.order = 1;
  Eigen::MatrixXd slow(2, 3), fast(2, 3);
  slow << 0.5, 0.8, -0.2, 0.0, 0.2, 0.8;
  fast << -0.2, -0.7, 0.1, 0.3, 0.0, -0.5;
  model.motions = {{slow, 0.04 * Eigen::MatrixXd::Identity(2, 2)},
                   {fast, 0.01 * Eigen::MatrixXd::Identity(2, 2)}};
  return model;
}

/// A series drawn from a model, with its true modes.
inline LabelledSeries simulate(const SwitchingModel& model, int n, Random& random) {
  const auto d = model.motions[0].covariance.rows();
  LabelledSeries out{Series::Zero(d, n), {}};
  for (int t = 0; t < n; ++t) {
    const Eigen::VectorXd p = t == 0
                                  ? model.chain.initial
                                  : Eigen::VectorXd(model.chain.transition.row(out.modes[t - 1]));
    out.modes.push_back(draw(random, p));
    if (t < model.order) continue;
    const Autoregression& motion = model.motions[out.modes[t]];
    const Eigen::MatrixXd L = motion.covariance.llt().matrixL();
    Eigen::VectorXd e(d);
    for (double& entry : e) entry = random.normal();
    out.series.col(t) = motion.coefficients * regressors(out.series, t, model.order) + L * e;
  }
  return out;
}

}  // namespace hybrid::testing
