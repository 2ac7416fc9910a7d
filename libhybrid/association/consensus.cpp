// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/consensus.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "libhybrid/association/gate.h"
#include "libhybrid/core/chi_square.h"

namespace hybrid {
namespace {

bool contradict(const IdentityHypotheses& h, int p, int q) {
  return (h.a[p] == h.a[q]) != (h.b[p] == h.b[q]);
}

/// One set under construction: differences and their covariance given that those of its pairs are
/// zero.
class Growth {
 public:
  Growth(const IdentityHypotheses& h, double gate)
      : h_(h), gate_(chi_square_quantile(gate, h.dim)), b_(h.difference), P_(h.covariance) {}

  GaussianScore score(int p) const {
    return gaussian_score(b_.segment(h_.dim * p, h_.dim),
                          P_.block(h_.dim * p, h_.dim * p, h_.dim, h_.dim));
  }

  void take(int p, const GaussianScore& score) {
    const int at = h_.dim * p;
    const Eigen::MatrixXd S = P_.block(at, at, h_.dim, h_.dim);
    const Eigen::MatrixXd gain = P_.middleCols(at, h_.dim) * S.inverse();
    b_ -= gain * Eigen::VectorXd(b_.segment(at, h_.dim));
    P_ -= gain * Eigen::MatrixXd(P_.middleRows(at, h_.dim));
    set_.pairs.push_back(p);
    set_.cost += score.cost - h_.gain[p];
    set_.chi_square += score.chi_square;
  }

  /// The best pair to take next; -1 if none lowers the cost.
  int next(GaussianScore& best_score) const {
    int best = -1;
    double least = 0.0;
    for (int p = 0; p < static_cast<int>(h_.a.size()); ++p) {
      const bool fits = std::all_of(set_.pairs.begin(), set_.pairs.end(), [&](int q) {
        return h_.a[p] != h_.a[q] && h_.b[p] != h_.b[q];
      });
      if (!fits) continue;
      const GaussianScore s = score(p);
      if (s.chi_square > gate_ || s.cost - h_.gain[p] >= least) continue;
      best = p;
      least = s.cost - h_.gain[p];
      best_score = s;
    }
    return best;
  }

  bool within_gate(const GaussianScore& s) const { return s.chi_square <= gate_; }
  ConsensusSet finish() && {
    std::sort(set_.pairs.begin(), set_.pairs.end());
    return std::move(set_);
  }

 private:
  const IdentityHypotheses& h_;
  double gate_;
  Eigen::VectorXd b_;
  Eigen::MatrixXd P_;
  ConsensusSet set_;
};

/// Whether what two pairs are off by is for the most part the same.
bool are_correlated(const IdentityHypotheses& h, int p, int q) {
  const auto block = [&](int i, int j) {
    return Eigen::MatrixXd(h.covariance.block(h.dim * i, h.dim * j, h.dim, h.dim));
  };
  return 2 * block(p, q).norm() > std::sqrt(block(p, p).norm() * block(q, q).norm());
}

/// Pairs whose differences are correlated, directly or through others.
std::vector<std::vector<int>> correlated_groups(const IdentityHypotheses& h,
                                                std::vector<int> pairs) {
  std::vector<std::vector<int>> groups;
  while (!pairs.empty()) {
    std::vector<int> group{pairs.back()};
    pairs.pop_back();
    for (std::size_t k = 0; k < group.size(); ++k) {
      const auto apart = std::partition(pairs.begin(), pairs.end(),
                                        [&](int q) { return !are_correlated(h, group[k], q); });
      std::copy(apart, pairs.end(), std::back_inserter(group));
      pairs.erase(apart, pairs.end());
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

ConsensusSet taken_together(const IdentityHypotheses& h, double gate,
                            const std::vector<int>& pairs) {
  Growth growth(h, gate);
  for (int p : pairs) growth.take(p, growth.score(p));
  return std::move(growth).finish();
}

}  // namespace

std::vector<ConsensusSet> consensus_sets(const IdentityHypotheses& hypotheses, double gate) {
  std::vector<ConsensusSet> sets;
  for (int seed = 0; seed < static_cast<int>(hypotheses.a.size()); ++seed) {
    Growth growth(hypotheses, gate);
    GaussianScore score = growth.score(seed);
    if (!growth.within_gate(score)) continue;
    int p = seed;
    while (p >= 0) {
      growth.take(p, score);
      p = growth.next(score);
    }
    ConsensusSet set = std::move(growth).finish();
    const bool known = std::any_of(sets.begin(), sets.end(),
                                   [&](const ConsensusSet& s) { return s.pairs == set.pairs; });
    if (!known) sets.push_back(std::move(set));
  }
  std::stable_sort(sets.begin(), sets.end(),
                   [](const auto& x, const auto& y) { return x.cost < y.cost; });
  return sets;
}

ConsensusSet decided_consensus(const IdentityHypotheses& hypotheses, double gate, double margin) {
  const std::vector<ConsensusSet> sets = consensus_sets(hypotheses, gate);
  if (sets.empty() || sets.front().cost > -margin) return {};
  const std::vector<int> pairs =
      undisputed(sets, margin, [&](int p, int q) { return contradict(hypotheses, p, q); });
  std::vector<int> believed;
  for (const std::vector<int>& group : correlated_groups(hypotheses, pairs)) {
    if (taken_together(hypotheses, gate, group).cost > -margin) continue;
    believed.insert(believed.end(), group.begin(), group.end());
  }
  return taken_together(hypotheses, gate, believed);
}

}  // namespace hybrid
