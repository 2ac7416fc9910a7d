// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/closures/objective_bound.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "libhybrid/solvers/relaxation.h"

namespace hybrid {
namespace {

constexpr double kNegligible = 1e-6;  // difference of objectives

/// A node of the search. Objectives are relative to those with all closures accepted at zero cost.
struct Node {
  std::vector<ClosureStatus> decisions;
  double poses = 0.0;              // bound on the cost of the relative poses in force
  std::vector<double> chi_square;  // of each closure at the poses of the relaxation
  double bound = 0.0;
};

/// Branch and bound over the decisions of a robust problem.
class DecisionSearch {
 public:
  DecisionSearch(const RobustProblem& problem, const Values& values, const MixtureOptions& mixture)
      : problem_(problem), values_(values) {
    for (const ContinuousFactorPtr& closure : problem.closures) {
      outlier_.push_back(0.5 * outlier_line(*closure, mixture).offset);
    }
  }

  /// The bound, at most `incumbent`.
  ObjectiveBound run(double incumbent, int budget) {
    Node root;
    root.decisions.assign(outlier_.size(), ClosureStatus::kUndecided);
    root.chi_square.assign(outlier_.size(), 0.0);
    if (budget > 0) relax(root);
    push(std::move(root));
    ObjectiveBound result;
    while (solves_ < budget && open_.top().bound < incumbent - kNegligible) {
      const Node node = open_.top();
      const std::size_t split = worst_open(node);
      if (split == outlier_.size()) break;  // all are decided: no other node has a lower bound
      open_.pop();
      Node out = node;
      out.decisions[split] = ClosureStatus::kRejected;
      push(std::move(out));
      Node in = node;
      in.decisions[split] = ClosureStatus::kAccepted;
      relax(in);
      push(std::move(in));
    }
    const Node& least = open_.top();
    result.bound = std::min(incumbent, least.bound);
    result.complete =
        !(least.bound < incumbent - kNegligible) || worst_open(least) == outlier_.size();
    result.solves = solves_;
    return result;
  }

 private:
  struct HigherBound {
    bool operator()(const Node& a, const Node& b) const { return a.bound > b.bound; }
  };

  /// Bounds the cost of the relative poses in force.
  void relax(Node& node) {
    ++solves_;
    std::vector<ContinuousFactorPtr> factors = problem_.trusted;
    for (std::size_t k = 0; k < outlier_.size(); ++k) {
      if (node.decisions[k] == ClosureStatus::kAccepted) factors.push_back(problem_.closures[k]);
    }
    const RelaxedPoses relaxed = relax_poses(factors, values_);
    node.poses = std::max(node.poses, relaxed.bound);
    node.chi_square.clear();
    for (const ContinuousFactorPtr& closure : problem_.closures) {
      node.chi_square.push_back(2.0 * closure->cost(relaxed.values));
    }
  }

  void push(Node node) {
    node.bound = node.poses;
    for (std::size_t k = 0; k < outlier_.size(); ++k) {
      if (node.decisions[k] == ClosureStatus::kRejected) node.bound += outlier_[k];
      if (node.decisions[k] == ClosureStatus::kUndecided) node.bound += std::min(0.0, outlier_[k]);
    }
    open_.push(std::move(node));
  }

  /// The undecided closure of largest residual; the number of closures if all are decided.
  std::size_t worst_open(const Node& node) const {
    std::size_t worst = outlier_.size();
    for (std::size_t k = 0; k < outlier_.size(); ++k) {
      if (node.decisions[k] != ClosureStatus::kUndecided) continue;
      if (worst == outlier_.size() || node.chi_square[k] > node.chi_square[worst]) worst = k;
    }
    return worst;
  }

  const RobustProblem& problem_;
  const Values& values_;
  std::vector<double> outlier_;  // least cost of a rejected closure
  std::priority_queue<Node, std::vector<Node>, HigherBound> open_;
  int solves_ = 0;
};

}  // namespace

ObjectiveBound bound_objective(const RobustProblem& problem, const Values& values,
                               const std::vector<bool>& accepted, const MixtureOptions& mixture,
                               int budget) {
  const double objective = joint_objective(problem, values, accepted, mixture).objective;
  double constant = 0.0;
  for (const ContinuousFactorPtr& factor : problem.trusted) constant += factor->log_normalizer();
  for (const ContinuousFactorPtr& closure : problem.closures) {
    constant += closure->log_normalizer() - std::log(mixture.inlier_weight);
  }
  ObjectiveBound result =
      DecisionSearch(problem, values, mixture).run(objective - constant, budget);
  result.bound += constant;
  result.gap = std::max(0.0, objective - result.bound);
  return result;
}

}  // namespace hybrid
