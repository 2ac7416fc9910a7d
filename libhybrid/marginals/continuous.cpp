// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/continuous.h"

#include "libhybrid/linear/selected_inverse.h"
#include "libhybrid/solvers/null_space.h"

namespace hybrid {

Eigen::Map<const Eigen::MatrixXd> Covariances::at(Key key) const {
  const auto it = places_.find(key);
  if (it == places_.end()) throw Error("variable " + to_string(key) + " has no covariance");
  return {entries_.data() + it->second.begin, it->second.dim, it->second.dim};
}

void Covariances::insert(Key key, const Eigen::MatrixXd& covariance) {
  places_[key] = {entries_.size(), static_cast<int>(covariance.rows())};
  entries_.insert(entries_.end(), covariance.data(), covariance.data() + covariance.size());
}

ContinuousMarginals::ContinuousMarginals(const HybridGraph& graph, const Estimate& estimate,
                                         const MarginalOptions& options)
    : problem_(graph, estimate.values, estimate.assignment, options.threads, options.weak,
               Elimination::kPlain),  // covariances come from the factor of the whole system
      pool_(options.threads) {
  problem_.linearize(problem_.load(estimate.values));
  problem_.assemble();
  under_constrained_ = factorize_undamped(problem_);
}

void ContinuousMarginals::check_valid() const {
  if (!valid()) throw Error("no covariances: " + under_constrained_message(under_constrained_));
}

Eigen::MatrixXd ContinuousMarginals::joint_covariance(const std::vector<Key>& keys) const {
  check_valid();
  const NormalEquations& system = problem_.system();
  const BlockCholesky& factor = system.cholesky();
  int columns = 0;
  for (Key key : keys) columns += system.dim(problem_.block(key));
  // Sigma = E' (L L')^-1 E = Y'Y with Y = L^-1 E.
  Eigen::MatrixXd y = Eigen::MatrixXd::Zero(system.scalars(), columns);
  int column = 0;
  for (Key key : keys) {
    const int block = problem_.block(key);
    const int start = system.start(block);
    for (int k = 0; k < system.dim(block); ++k, ++column) {
      y(start + k, column) = 1.0;
      factor.solve_lower_along(factor.supernode_of(start), y.col(column).data());
    }
  }
  return y.transpose() * y;
}

Covariances ContinuousMarginals::all() const {
  check_valid();
  const NormalEquations& system = problem_.system();
  const SelectedInverse inverse(system.cholesky(), pool_);
  Covariances result;
  for (int block = 0; block < problem_.block_count(); ++block) {
    result.insert(problem_.key(block),
                  inverse.diagonal_block(system.start(block), system.dim(block)));
  }
  return result;
}

}  // namespace hybrid
