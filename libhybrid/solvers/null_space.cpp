// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/null_space.h"

#include <algorithm>
#include <cmath>

namespace hybrid {
namespace {

constexpr double kRegularization = 1e-9;
constexpr int kInverseIterations = 4;
/// A variable is named when it moves by this share of the one that moves most.
constexpr double kNamedShare = 0.05;
constexpr std::size_t kNamedInMessage = 5;

/// Scales v to unit length in the metric of the diagonal of H.
void scale_to_unit(const std::vector<double>& diagonal, std::vector<double>& v) {
  double sum = 0.0;
  for (std::size_t i = 0; i < v.size(); ++i) sum += diagonal[i] * v[i] * v[i];
  const double scale = 1.0 / std::sqrt(sum);
  for (double& x : v) x *= scale;
}

}  // namespace

std::vector<Key> under_constrained_variables(Problem& problem) {
  std::vector<Key> keys;
  NormalEquations& system = problem.system();
  for (int block : system.untouched()) keys.push_back(problem.key(block));
  if (!keys.empty() || problem.factorize(kRegularization) >= 0) return keys;

  const std::vector<double>& diagonal = system.diagonal();
  std::vector<double> v(system.scalars());
  for (std::size_t i = 0; i < v.size(); ++i) {
    v[i] = (1.0 + std::fmod(0.6180339887498949 * i, 1.0)) / std::sqrt(diagonal[i]);
  }
  for (int k = 0; k < kInverseIterations; ++k) {
    scale_to_unit(diagonal, v);
    for (std::size_t i = 0; i < v.size(); ++i) v[i] *= diagonal[i];
    system.solve(v.data());
  }
  scale_to_unit(diagonal, v);

  std::vector<std::pair<double, int>> moves;
  for (int block = 0; block < problem.block_count(); ++block) {
    double sum = 0.0;
    for (int i = system.start(block); i < system.start(block) + system.dim(block); ++i) {
      sum += diagonal[i] * v[i] * v[i];
    }
    moves.emplace_back(-std::sqrt(sum), block);
  }
  std::sort(moves.begin(), moves.end());
  for (const auto& [move, block] : moves) {
    if (move <= kNamedShare * moves.front().first) keys.push_back(problem.key(block));
  }
  return keys;
}

std::vector<Key> factorize_undamped(Problem& problem) {
  const int failed = problem.factorize(0.0);
  if (failed < 0 && problem.system().smallest_pivot_ratio() >= kSingularPivotRatio) return {};
  std::vector<Key> keys = under_constrained_variables(problem);
  if (keys.empty() && failed >= 0) keys.push_back(problem.key(failed));
  return keys;
}

std::string under_constrained_message(const std::vector<Key>& keys) {
  std::string names;
  for (std::size_t i = 0; i < std::min(keys.size(), kNamedInMessage); ++i) {
    names += (i == 0 ? "" : ", ") + to_string(keys[i]);
  }
  if (keys.size() > kNamedInMessage) names += ", ...";
  return "the factors leave " + names + " (" + std::to_string(keys.size()) +
         (keys.size() == 1 ? " variable" : " variables") +
         ") undetermined: add a prior or measurements that hold them";
}

}  // namespace hybrid
