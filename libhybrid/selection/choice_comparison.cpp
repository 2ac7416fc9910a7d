// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/detail/choice_comparison.h"

#include <algorithm>
#include <memory>
#include <set>

#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/relative_poses.h"
#include "libhybrid/selection/detail/segment_transforms.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {

ChoiceComparison::ChoiceComparison(const IncrementalSmoother& smoother,
                                   const std::vector<HybridFactorPtr>& choices,
                                   const std::vector<ContinuousFactorPtr>& closures)
    : choices_(choices) {
  std::set<Key> keys;
  for (const HybridFactorPtr& choice : choices) {
    keys.insert(choice->keys().begin(), choice->keys().end());
    graph_.add(choice);
  }
  for (const ContinuousFactorPtr& closure : closures) {
    keys.insert(closure->keys().begin(), closure->keys().end());
    graph_.add(closure);
  }
  std::vector<Key> piece;
  std::vector<SE2> poses;
  const auto add_piece = [&] {
    if (piece.size() > 1) {
      graph_.emplace<RelativePoses<SE2>>(
          RelativePoses<SE2>::marginal(piece, poses, smoother.joint_covariance(piece)));
    }
    piece.clear();
    poses.clear();
  };
  for (Key key : keys) {
    const bool begins = std::any_of(choices.begin(), choices.end(),
                                    [&](const auto& choice) { return choice->keys()[1] == key; });
    if (begins) add_piece();
    piece.push_back(key);
    poses.push_back(smoother.values().at<SE2>(key));
    poses_.insert(key, poses.back());
  }
  add_piece();
  graph_.emplace<Prior<SE2>>(*keys.begin(), poses_.at<SE2>(*keys.begin()), Noise::unit(3));
}

double ChoiceComparison::cost(const std::vector<int>& values) const {
  SegmentTransforms motions;
  Estimate start{poses_, {}};
  for (std::size_t c = 0; c < choices_.size(); ++c) {
    start.assignment.set(choices_[c]->discrete_keys()[0].key, values[c]);
    motions.add(*choices_[c], values[c], poses_);
  }
  for (Key key : poses_.keys()) start.values.update(key, motions(key, poses_.at<SE2>(key)));
  SolverOptions options;
  options.threads = 1;
  options.max_iterations = 20;
  options.relative_decrease = 1e-3;
  start.values = levenberg_marquardt(graph_, start, options).values;
  return objective(graph_, start.values, start.assignment);
}

}  // namespace hybrid
