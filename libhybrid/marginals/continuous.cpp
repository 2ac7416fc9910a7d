// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/continuous.h"

#include <algorithm>

#include "libhybrid/linear/path_inverse.h"
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

std::vector<Key> Covariances::keys() const {
  std::vector<Key> keys;
  keys.reserve(places_.size());
  for (const auto& [key, place] : places_) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  return keys;
}

ContinuousMarginals::ContinuousMarginals(const HybridGraph& graph, const Estimate& estimate,
                                         const MarginalOptions& options)
    : problem_(graph, estimate.values, estimate.assignment, options.threads,
               WeakComponents::kCoupled,
               Elimination::kPlain),  // covariances come from the factor of the whole system
      pool_(options.threads) {
  problem_.linearize(problem_.load(estimate.values));
  problem_.assemble();
  if (is_clearly_regular(problem_)) return;
  extended_.emplace(problem_.extended_factor());
  for (const FreeVariable& variable : free_variables(problem_, *extended_)) {
    under_constrained_.push_back(variable.key);
  }
}

std::vector<int> ContinuousMarginals::determined_blocks(const std::vector<Key>& keys) const {
  std::vector<int> blocks;
  for (Key key : keys) {
    blocks.push_back(problem_.block(key));
    if (extended_ && extended_->free_directions(blocks.back()).cols() > 0) {
      throw Error("no covariance of " + to_string(key) + ": " +
                  under_constrained_message(under_constrained_));
    }
  }
  return blocks;
}

Eigen::MatrixXd ContinuousMarginals::joint_covariance(const std::vector<Key>& keys) const {
  const std::vector<int> blocks = determined_blocks(keys);
  if (extended_) return extended_->covariance(blocks);
  const NormalEquations& system = problem_.system();
  PathInverse inverse(system.cholesky());
  std::vector<int> at;
  int size = 0;
  for (int block : blocks) {
    at.push_back(size);
    size += system.dim(block);
  }
  Eigen::MatrixXd joint(size, size);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const int rows = system.dim(blocks[i]), columns = system.dim(blocks[j]);
      const Eigen::MatrixXd block =
          inverse.block(system.start(blocks[i]), rows, system.start(blocks[j]), columns);
      joint.block(at[i], at[j], rows, columns) = block;
      if (j < i) joint.block(at[j], at[i], columns, rows) = block.transpose();
    }
  }
  return joint;
}

Covariances ContinuousMarginals::all() const {
  Covariances result;
  if (extended_) {
    for (int block = 0; block < problem_.block_count(); ++block) {
      if (extended_->free_directions(block).cols() > 0) continue;
      result.insert(problem_.key(block), extended_->covariance({block}));
    }
    return result;
  }
  const NormalEquations& system = problem_.system();
  const SelectedInverse inverse(system.cholesky(), pool_);
  for (int block = 0; block < problem_.block_count(); ++block) {
    result.insert(problem_.key(block),
                  inverse.diagonal_block(system.start(block), system.dim(block)));
  }
  return result;
}

}  // namespace hybrid
