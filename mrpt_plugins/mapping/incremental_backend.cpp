// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/incremental_backend.h"

#include <unordered_set>

#include "libhybrid/discrete/inference.h"

namespace hybrid {
namespace {

/// What the factors of a change add to the objective beside their cost.
double constant_of(const Delta& delta, const Assignment& assignment) {
  double sum = 0;
  for (const ContinuousFactorPtr& factor : delta.continuous) sum += factor->log_normalizer();
  for (const Table& table : delta.discrete) sum += table.cost(assignment);
  for (const HybridFactorPtr& factor : delta.hybrid) {
    const Component component = factor->given(assignment);
    sum += component.constant;
    if (component.factor != nullptr) sum += component.factor->log_normalizer();
  }
  return sum;
}

}  // namespace

BackendReport IncrementalBackend::update(const Delta& delta) {
  const UpdateReport update = smoother_.update(delta);
  if (update.status == UpdateReport::Status::kSingular) throw Error(update.message);
  if (update.flips > 0 || !delta.remove.empty()) {
    constant_ = smoother_.objective() - smoother_.cost();
  } else {
    constant_ += constant_of(delta, smoother_.assignment());
  }
  return report_of(update);
}

BackendReport IncrementalBackend::finish() {
  const UpdateReport update = smoother_.converge();
  constant_ = smoother_.objective() - smoother_.cost();
  return report_of(update);
}

BackendReport IncrementalBackend::report_of(const UpdateReport& update) const {
  BackendReport report;
  report.seconds = update.seconds;
  report.iterations = update.rounds;
  report.flips = update.flips;
  report.relinearized = update.relinearized;
  report.objective = smoother_.objective();
  report.cost = report.objective - constant_;
  report.half_steps = update.objectives;
  if (update.status != UpdateReport::Status::kOk) report.warnings.push_back(update.message);
  return report;
}

Uncertainty IncrementalBackend::uncertainty(const std::vector<Key>& continuous,
                                            const std::vector<DiscreteKey>& discrete) const {
  Uncertainty out;
  const std::unordered_set<Key> wanted(continuous.begin(), continuous.end());
  if (!wanted.empty()) {
    smoother_.visit_covariances([&](Key key, const Eigen::MatrixXd& covariance) {
      if (wanted.count(key) != 0) out.covariances[key] = covariance;
    });
  }
  for (const DiscreteKey& key : discrete) {
    const DiscreteMarginals marginals = discrete_marginals(smoother_.component(key.key));
    const auto p = marginals.at(key.key);
    out.probabilities[key.key].assign(p.data(), p.data() + p.size());
  }
  return out;
}

}  // namespace hybrid
