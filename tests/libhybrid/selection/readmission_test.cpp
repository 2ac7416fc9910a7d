// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/detail/readmission.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/selection/closure_selection.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

constexpr int kPosesOfLap = 100;
constexpr int kTrue = 50, kFalse = 20;  // closures of drifted_laps

SE2 on_circle(int k) {
  const double angle = 2.0 * M_PI * k / kPosesOfLap;
  return SE2(10.0 * std::cos(angle), 10.0 * std::sin(angle), angle + 0.5 * M_PI);
}

/// Laps of a circle with noise of a centimetre that is stated as metres, so that no closure is
/// implausible by odometry. Closures to the lap before come first, then false ones between any two
/// poses: these fill the system.
struct LooseLaps {
  LooseLaps(int poses, int lies) {
    testing::Random random(5);
    const Noise noise = Noise::diagonal(Eigen::Vector3d(2.0, 2.0, 0.5));
    const auto add = [&](int from, int to, const SE2& moved) {
      const Eigen::Vector3d e(random.normal(0.01), random.normal(0.01), random.normal(0.0025));
      graph.poses2.push_back({Key('x', from), Key('x', to), moved * SE2::exp(e), noise});
    };
    for (int k = 1; k < poses; ++k) add(k - 1, k, on_circle(k - 1).inverse() * on_circle(k));
    for (int k = kPosesOfLap; k < poses; k += 2, ++true_closures) add(k, k - kPosesOfLap, SE2());
    while (static_cast<int>(graph.poses2.size()) < poses - 1 + true_closures + lies) {
      const int a = static_cast<int>(random.uniform(0.0, poses));
      const int b = static_cast<int>(random.uniform(0.0, poses));
      if (std::abs(a - b) < 2) continue;
      add(a, b,
          SE2(random.uniform(-9.0, 9.0), random.uniform(-9.0, 9.0), random.uniform(-3.0, 3.0)));
    }
  }
  RobustProblem problem() const {
    return to_robust_problem(graph, initialize_from_odometry(graph));
  }
  PoseGraph graph;
  int true_closures = 0;
};

TEST(Readmission, AffordsNoBatchThatFillsTheSystem) {
  const LooseLaps laps(1500, 1500);
  const RobustProblem problem = laps.problem();
  const ClosureSelectionOptions options;
  Readmission map(problem, options);
  map.begin();
  std::vector<Candidate> batch;
  for (int k = 0; k < laps.true_closures; ++k) batch.push_back({0.0, k});
  EXPECT_TRUE(map.affords(batch));
  for (int k = 0; k < 1500; ++k) batch.push_back({0.0, laps.true_closures + k});
  EXPECT_FALSE(map.affords(batch));
}

TEST(Readmission, SelectionEndsWhereAllFalseClosuresArePlausibleAndFillTheSystem) {
  const LooseLaps laps(1500, 1500);
  const RobustResult result = select_closures(laps.problem());
  int wrong = 0;
  for (int k = 0; k < static_cast<int>(result.decisions.size()); ++k) {
    wrong += result.decisions[k].accepted() != (k < laps.true_closures) ? 1 : 0;
  }
  EXPECT_EQ(wrong, 0);
}

/// Two laps of a circle with so much noise that a lap later no closure can be told alone, though
/// those near each other agree: true closures between the laps, then false ones.
RobustProblem drifted_laps() {
  testing::Random random(3);
  const Eigen::Vector3d sigmas(0.3, 0.3, 0.06), exact(0.05, 0.05, 0.01);
  PoseGraph graph;
  const auto add = [&](int from, int to, const SE2& moved, const Eigen::Vector3d& sigma) {
    const Eigen::Vector3d e(random.normal(sigma[0]), random.normal(sigma[1]),
                            random.normal(sigma[2]));
    graph.poses2.push_back(
        {Key('x', from), Key('x', to), moved * SE2::exp(e), Noise::diagonal(sigma)});
  };
  for (int k = 1; k < 2 * kPosesOfLap; ++k) {
    add(k - 1, k, on_circle(k - 1).inverse() * on_circle(k), sigmas);
  }
  for (int k = 0; k < kTrue; ++k) add(2 * k, kPosesOfLap + 2 * k, SE2(), exact);
  for (int k = 0; k < kFalse; ++k) {
    add(4 * k, kPosesOfLap + 4 * k + 1,
        SE2(random.uniform(5.0, 9.0), random.uniform(-9.0, 9.0), random.uniform(-3.0, 3.0)), exact);
  }
  return to_robust_problem(graph, initialize_from_odometry(graph));
}

TEST(Readmission, ClosuresThatAgreeAreFoundByShortPathsWhereNoneIsToldAlone) {
  const RobustProblem problem = drifted_laps();
  const ClosureSelectionOptions options;
  Readmission map(problem, options);
  map.begin();
  ASSERT_TRUE(map.candidates().empty());
  std::vector<bool> found(problem.closures.size(), false);
  for (const Candidate& member : map.clusters()) found[member.closure] = true;
  const std::vector<Candidate> beyond = map.beyond({{0.0, 0}});
  EXPECT_GT(beyond.size(), std::size_t(kTrue) / 2);
  for (const Candidate& candidate : beyond) EXPECT_LT(candidate.closure, kTrue);
  for (int k = 0; k < kTrue + kFalse; ++k) EXPECT_EQ(found[k], k < kTrue) << k;
}

TEST(Readmission, DriftedLapsAreSelectedInAFewMacroSteps) {
  const RobustProblem problem = drifted_laps();
  const RobustResult result = select_closures(problem);
  for (int k = 0; k < kTrue + kFalse; ++k) {
    EXPECT_EQ(result.decisions[k].accepted(), k < kTrue) << k;
  }
  EXPECT_LE(result.objectives.size(), 4U);
}

}  // namespace
}  // namespace hybrid
