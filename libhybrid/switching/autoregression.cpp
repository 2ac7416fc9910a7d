// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/switching/autoregression.h"

#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/core/noise.h"
#include "libhybrid/discrete/inference.h"

namespace hybrid {
namespace {

void check_fit(const SwitchingModel& model, const Series& series) {
  check(model.chain);
  if (model.modes() != model.chain.modes()) {
    throw Error("a switching model has " + std::to_string(model.modes()) + " motions for " +
                std::to_string(model.chain.modes()) + " modes");
  }
  if (model.order < 0) throw Error("the order of a switching model must not be negative");
  const auto d = series.rows(), k = 1 + d * model.order;
  for (int m = 0; m < model.modes(); ++m) {
    const Autoregression& motion = model.motions[m];
    if (motion.coefficients.rows() != d || motion.coefficients.cols() != k) {
      throw Error("the motion of mode " + std::to_string(m) + " has " +
                  std::to_string(motion.coefficients.rows()) + " x " +
                  std::to_string(motion.coefficients.cols()) + " coefficients; a series of " +
                  std::to_string(d) + " values per instant and order " +
                  std::to_string(model.order) + " needs " + std::to_string(d) + " x " +
                  std::to_string(k));
    }
  }
  if (series.cols() == 0) throw Error("a series without any instant has no modes");
  if (!series.allFinite()) throw Error("a series holds a value that is not finite");
}

std::vector<const Table*> pointers(const std::vector<Table>& tables) {
  std::vector<const Table*> out;
  for (const Table& table : tables) out.push_back(&table);
  return out;
}

}  // namespace

Eigen::VectorXd regressors(const Series& series, int t, int order) {
  const auto d = series.rows();
  Eigen::VectorXd x(1 + d * order);
  x[0] = 1.0;
  for (int j = 1; j <= order; ++j) x.segment(1 + (j - 1) * d, d) = series.col(t - j);
  return x;
}

std::vector<Table> switching_tables(const SwitchingModel& model, const Series& series) {
  check_fit(model, series);
  const int n = static_cast<int>(series.cols()), modes = model.modes();
  std::vector<DiscreteKey> keys;
  for (int t = 0; t < n; ++t) keys.push_back(mode_key(t, modes));
  std::vector<Table> tables = chain_tables(model.chain, keys);
  std::vector<Noise> noises;
  for (const Autoregression& motion : model.motions) {
    noises.push_back(Noise::covariance(motion.covariance));
  }
  for (int t = model.order; t < n; ++t) {
    const Eigen::VectorXd x = regressors(series, t, model.order);
    std::vector<double> costs(modes);
    for (int m = 0; m < modes; ++m) {
      const Eigen::VectorXd e = series.col(t) - model.motions[m].coefficients * x;
      costs[m] =
          noises[m].log_normalizer() + 0.5 * (noises[m].sqrt_information() * e).squaredNorm();
    }
    tables.emplace_back(std::vector<DiscreteKey>{keys[t]}, std::move(costs));
  }
  return tables;
}

Labelling label(const SwitchingModel& model, const Series& series) {
  const std::vector<Table> tables = switching_tables(model, series);
  const std::vector<const Table*> factors = pointers(tables);
  const Assignment best = solve_discrete(factors).assignment;
  const DiscreteMarginals marginals = discrete_marginals(factors);
  Labelling out;
  out.log_likelihood = marginals.log_partition();
  out.probabilities.resize(model.modes(), series.cols());
  for (int t = 0; t < series.cols(); ++t) {
    const Key key = mode_key(t, model.modes()).key;
    out.modes.push_back(best.at(key));
    out.probabilities.col(t) = marginals.at(key);
  }
  return out;
}

}  // namespace hybrid
