// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Covariances of the smoother, from its Bayes tree.
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/smoother/detail/map_of.h"

namespace hybrid {

Eigen::MatrixXd IncrementalSmoother::joint_covariance(const std::vector<Key>& keys) const {
  if (!tree_is_whole()) return ContinuousMarginals(graph_, estimate()).joint_covariance(keys);
  std::vector<int> slots;
  for (Key key : keys) slots.push_back(values().slot(key));
  return tree_.joint_covariance(slots, MapOf(*this).charts());
}

Eigen::MatrixXd IncrementalSmoother::joint_covariance(const std::vector<Key>& keys,
                                                      const Eigen::MatrixXd& J) const {
  if (!tree_is_whole()) return J * joint_covariance(keys) * J.transpose();
  std::vector<int> slots;
  for (Key key : keys) slots.push_back(values().slot(key));
  return tree_.joint_covariance(slots, J, MapOf(*this).charts());
}

void IncrementalSmoother::visit_covariances(
    const std::function<void(Key, const Eigen::MatrixXd&)>& visit) const {
  if (!tree_is_whole()) {
    const Covariances all = ContinuousMarginals(graph_, estimate()).all();
    for (Key key : values().keys()) {
      if (all.contains(key)) visit(key, all.at(key));
    }
    return;
  }
  tree_.visit_covariances(
      [&](int slot, const Eigen::MatrixXd& covariance) { visit(values().key(slot), covariance); },
      MapOf(*this).charts());
}

}  // namespace hybrid
