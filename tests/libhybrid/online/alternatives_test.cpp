// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Closures of which at most one is true, such as all poses that one search found.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/online/online_selection.h"
#include "libhybrid/selection/closure_selection.h"
#include "libhybrid/selection/innovation.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "libhybrid/solvers/problem.h"
#include "tests/support/random.h"

namespace hybrid::alternative_closures {
namespace {

constexpr int kLap = 40;
constexpr int kPoses = 3 * kLap;
constexpr double kSigma = 0.05;
constexpr double kApart = 0.3;  // of alternatives: six sigmas, which the gate lets in

Key pose(int k) {
  return {'x', static_cast<std::uint64_t>(k)};
}

SE2 on_circle(int k) {
  const double angle = 2.0 * M_PI * k / kLap;
  return {6.0 * std::cos(angle), 6.0 * std::sin(angle), angle + 0.5 * M_PI};
}

/// Laps of a circle. Every second pose is found at its place of the lap before, and 0.3 m from
/// there, in an order that changes.
struct AmbiguousLaps {
  explicit AmbiguousLaps(std::uint64_t seed = 3) : random(seed) {
    const auto between = [&](int a, int b, double sigma, const SE2& off) {
      const Eigen::Vector3d e{random.normal(sigma), random.normal(sigma),
                              random.normal(0.2 * sigma)};
      const SE2 motion = on_circle(a).between(on_circle(b)) * SE2::exp(e) * off;
      return std::make_shared<BetweenSE2>(
          pose(a), pose(b), motion, Noise::diagonal(Eigen::Vector3d(sigma, sigma, 0.2 * sigma)));
    };
    for (int k = 1; k < kPoses; ++k) odometry.push_back(between(k - 1, k, 0.01, SE2()));
    for (int k = kLap; k < kPoses; k += 2) {
      const bool true_first = k % 4 == 0;
      for (const bool is_true : {true_first, !true_first}) {
        const SE2 off = is_true ? SE2() : SE2(k % 3 == 0 ? kApart : -kApart, 0.0, 0.0);
        alternatives.add(closures.size() - (is_true == true_first ? 0 : 1));
        closures.push_back(between(k - kLap, k, kSigma, off));
        truth.push_back(is_true);
      }
    }
  }
  ContinuousFactorPtr start() const {
    return std::make_shared<Prior<SE2>>(pose(0), on_circle(0), Noise::isotropic(3, 1e-3));
  }
  RobustProblem problem() const {
    RobustProblem problem;
    problem.trusted = odometry;
    problem.trusted.push_back(start());
    problem.closures = closures;
    problem.alternatives = alternatives;
    for (int k = 0; k < kPoses; ++k) problem.initial.insert(pose(k), on_circle(k));
    return problem;
  }

  testing::Random random;
  std::vector<ContinuousFactorPtr> odometry, closures;
  std::vector<bool> truth;
  Alternatives alternatives;
};

void expect_one_of_each(const AmbiguousLaps& laps, const std::vector<ClosureDecision>& decisions) {
  ASSERT_EQ(decisions.size(), laps.truth.size());
  for (std::size_t k = 0; k < decisions.size(); k += 2) {
    SCOPED_TRACE(k);
    const double p = decisions[k].inlier_probability, q = decisions[k + 1].inlier_probability;
    EXPECT_LE(p + q, 1.0 + 1e-12);
    EXPECT_GT(p + q, 0.9);
    EXPECT_FALSE(decisions[k].accepted() && decisions[k + 1].accepted());
  }
}

int right(const AmbiguousLaps& laps, const std::vector<ClosureDecision>& decisions) {
  int count = 0;
  for (std::size_t k = 0; k < decisions.size(); ++k) {
    count += decisions[k].accepted() && laps.truth[k] ? 1 : 0;
  }
  return count;
}

int accepted(const std::vector<ClosureDecision>& decisions) {
  int count = 0;
  for (const ClosureDecision& decision : decisions) count += decision.accepted() ? 1 : 0;
  return count;
}

/// How many decisions are wrong if their probabilities are right.
double expected_wrong(const std::vector<ClosureDecision>& decisions) {
  double sum = 0;
  for (const ClosureDecision& decision : decisions) {
    if (decision.accepted()) sum += 1 - decision.inlier_probability;
  }
  return sum;
}

TEST(AlternativeClosures, BatchSelectionTakesOneOfEachSet) {
  constexpr int kWorlds = 8;
  int all = 0, of_truth = 0;
  double wrong = 0;
  for (int seed = 1; seed <= kWorlds; ++seed) {
    const AmbiguousLaps laps(static_cast<std::uint64_t>(seed));
    const RobustResult result = select_closures(laps.problem());
    expect_one_of_each(laps, result.decisions);
    all += accepted(result.decisions);
    of_truth += right(laps, result.decisions);
    wrong += expected_wrong(result.decisions);
  }
  EXPECT_GE(of_truth, 25 * kWorlds);  // of 40 each, of which some cannot be told apart
  EXPECT_LE(all - of_truth, wrong + 3 * std::sqrt(wrong));
  RobustProblem problem = AmbiguousLaps().problem();
  problem.alternatives = {};
  EXPECT_GT(accepted(select_closures(problem).decisions), 60);  // each fits by itself
}

TEST(AlternativeClosures, OnlineSelectionTakesOneOfEachSet) {
  const AmbiguousLaps laps;
  OnlineSelection selection;
  std::size_t next = 0;
  for (int k = 0; k < kPoses; ++k) {
    Delta delta;
    delta.values.insert(pose(k), on_circle(k));
    delta.continuous.push_back(k == 0 ? laps.start()
                                      : laps.odometry[static_cast<std::size_t>(k) - 1]);
    std::vector<ContinuousFactorPtr> found;
    Alternatives alternatives;
    while (next < laps.closures.size() && laps.closures[next]->keys()[1] == pose(k)) {
      alternatives.add(0);
      found.push_back(laps.closures[next++]);
    }
    selection.update(delta, found, alternatives);
    for (std::size_t i = 0; i + 1 < next; i += 2) {
      ASSERT_FALSE(selection.status(i) == ClosureStatus::kAccepted &&
                   selection.status(i + 1) == ClosureStatus::kAccepted)
          << i << " at " << k;
    }
  }
  selection.finish();
  const std::vector<ClosureDecision> evaluated = selection.decisions();
  expect_one_of_each(laps, evaluated);
  EXPECT_GE(right(laps, evaluated), 20);
  EXPECT_LE(accepted(evaluated) - right(laps, evaluated), 2 + 3 * expected_wrong(evaluated));
  for (std::size_t k = 0; k < evaluated.size(); ++k) {
    EXPECT_EQ(selection.status(k) == ClosureStatus::kAccepted, evaluated[k].accepted()) << k;
  }
  // Of one covariance for each closure, as between evaluations of all.
  selection.update({});
  const std::vector<ClosureDecision> predicted = selection.decisions();
  expect_one_of_each(laps, predicted);
  for (std::size_t k = 0; k < evaluated.size(); ++k) {
    EXPECT_NEAR(predicted[k].inlier_probability, evaluated[k].inlier_probability, 0.02) << k;
    EXPECT_NEAR(predicted[k].margin, evaluated[k].margin, 0.5) << k;
  }
}

// What is predicted of a closure as if another one were not is what a map without that one
// predicts.
TEST(AlternativeClosures, AreWeighedAsIfTheOtherWereNot) {
  const AmbiguousLaps laps;
  const auto predict = [&](bool with_other, Innovation& of, Innovation* part,
                           Eigen::MatrixXd* cross) {
    HybridGraph graph;
    for (const auto& factor : laps.odometry) graph.add(factor);
    graph.add(laps.start());
    if (with_other) graph.add(laps.closures[0]);
    Values values = laps.problem().initial;
    Problem problem(graph, values, {});
    Problem::State state = problem.load(values);
    levenberg_marquardt(problem, state);
    problem.linearize(state);
    problem.assemble();
    ASSERT_EQ(problem.factorize(0.0), -1);
    InnovationPredictor predictor(problem, state);
    of = predictor.predict(*laps.closures[1]);
    if (part == nullptr) return;
    *part = predictor.predict(*laps.closures[0]);
    *cross = predictor.cross(*laps.closures[1], *laps.closures[0]);
  };
  Innovation expected, with, part;
  Eigen::MatrixXd cross;
  predict(false, expected, nullptr, nullptr);
  predict(true, with, &part, &cross);
  const Innovation actual = without(with, part, cross);
  EXPECT_GT((with.APAt - expected.APAt).norm(), 0.1 * expected.APAt.norm());
  EXPECT_LT((actual.APAt - expected.APAt).norm(), 0.02 * expected.APAt.norm());
  EXPECT_GT((with.b - expected.b).norm(), 0.1);
  EXPECT_LT((actual.b - expected.b).norm(), 0.02);
}

}  // namespace
}  // namespace hybrid::alternative_closures
