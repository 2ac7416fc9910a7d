// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/choices/detail/choice_comparison.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include "libhybrid/choices/detail/segment_transforms.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/relative_poses.h"
#include "libhybrid/selection/evidence.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

constexpr int kIterations = 20;
constexpr double kDecrease = 1e-3;  // of the cost, below which an iteration is the last

}  // namespace

template <class Pose>
ChoiceComparison<Pose>::ChoiceComparison(const IncrementalSmoother& smoother,
                                         const std::vector<HybridFactorPtr>& choices,
                                         const std::vector<ContinuousFactorPtr>& true_closures,
                                         const std::vector<ContinuousFactorPtr>& uncertain_closures,
                                         const ClosureSelectionOptions& options, double radius)
    : choices_(choices),
      fixed_(true_closures),
      uncertain_(uncertain_closures),
      options_(options),
      radius_(radius) {
  options_.solver.threads = 1;
  options_.solver.max_iterations = kIterations;
  options_.solver.relative_decrease = kDecrease;
  std::set<Key> keys;
  const auto note = [&](const auto& factor) {
    keys.insert(factor->keys().begin(), factor->keys().end());
  };
  std::for_each(choices.begin(), choices.end(), note);
  std::for_each(fixed_.begin(), fixed_.end(), note);
  std::for_each(uncertain_.begin(), uncertain_.end(), note);
  std::vector<Key> piece;
  std::vector<Pose> poses;
  const auto add_piece = [&] {
    if (piece.size() > 1) {
      fixed_.push_back(std::make_shared<RelativePoses<Pose>>(
          RelativePoses<Pose>::marginal(piece, poses, smoother.joint_covariance(piece))));
    }
    piece.clear();
    poses.clear();
  };
  for (Key key : keys) {
    const bool begins = std::any_of(choices.begin(), choices.end(),
                                    [&](const auto& choice) { return choice->keys()[1] == key; });
    if (begins) add_piece();
    piece.push_back(key);
    poses.push_back(smoother.values().at<Pose>(key));
    poses_.insert(key, poses.back());
  }
  add_piece();
  fixed_.push_back(std::make_shared<Prior<Pose>>(*keys.begin(), poses_.at<Pose>(*keys.begin()),
                                                 Noise::unit(Pose::kDim)));
}

/// The poses if the pieces move rigidly.
template <class Pose>
Values ChoiceComparison<Pose>::start(const std::vector<int>& values) const {
  SegmentTransforms<Pose> motions;
  for (std::size_t c = 0; c < choices_.size(); ++c) motions.add(*choices_[c], values[c], poses_);
  Values start = poses_;
  for (Key key : poses_.keys()) start.update(key, motions(key, poses_.at<Pose>(key)));
  return start;
}

template <class Pose>
typename ChoiceComparison<Pose>::Fit ChoiceComparison<Pose>::fit(
    const std::vector<int>& values) const {
  RobustProblem problem{fixed_, uncertain_, start(values)};
  double constant = 0.0;
  for (std::size_t c = 0; c < choices_.size(); ++c) {
    Assignment assignment;
    assignment.set(choices_[c]->discrete_keys()[0].key, values[c]);
    const Component component = choices_[c]->given(assignment);
    problem.trusted.emplace_back(choices_[c], component.factor);
    constant += component.constant;
  }
  HybridGraph graph;
  Fit fit;
  if (!uncertain_.empty()) {
    const RobustResult selected = select_closures(problem, options_);
    problem.initial = selected.values;
    for (std::size_t k = 0; k < uncertain_.size(); ++k) {
      fit.in.push_back(selected.decisions[k].accepted());
      if (fit.in.back()) {
        graph.add(uncertain_[k]);
      } else {
        constant += log_volume(*uncertain_[k], radius_);
      }
    }
  }
  for (const ContinuousFactorPtr& factor : problem.trusted) graph.add(factor);
  Problem system(graph, problem.initial, {}, 1);
  Problem::State state = system.load(problem.initial);
  levenberg_marquardt(system, state, options_.solver);
  fit.cost = system.linearize(state);
  system.assemble();
  const bool regular = system.factorize(0.0) < 0;
  fit.evidence =
      regular ? -fit.cost - system.constant() - constant - 0.5 * system.system().log_determinant()
              : -kInfinity;
  return fit;
}

template class ChoiceComparison<SE2>;
template class ChoiceComparison<SE3>;

}  // namespace hybrid
