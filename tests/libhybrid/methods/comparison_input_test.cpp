// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "libhybrid/methods/robust_methods.h"
#include "tests/support/corrupted_graph.h"

namespace hybrid {
namespace {

/// The comparison methods, each on the same bad graphs.
class ComparisonInput : public ::testing::TestWithParam<std::string> {
 protected:
  static RobustResult solve(const RobustProblem& problem) {
    RobustTask task;
    task.problem = problem;
    return robust_method(GetParam()).solve(task, {});
  }

  /// A result is there, with a number for everything.
  static void expect_finite(const RobustProblem& problem, const RobustResult& result) {
    EXPECT_EQ(result.decisions.size(), problem.closures.size());
    EXPECT_TRUE(std::isfinite(result.objective));
    for (Key key : problem.initial.keys()) {
      const SE2 pose = result.values.at<SE2>(key);
      EXPECT_TRUE(std::isfinite(pose.x()) && std::isfinite(pose.y()) &&
                  std::isfinite(pose.angle()));
    }
    for (const ClosureDecision& decision : result.decisions) {
      EXPECT_GE(decision.inlier_probability, 0.0);
      EXPECT_LE(decision.inlier_probability, 1.0);
    }
  }
};

TEST_P(ComparisonInput, NoClosures) {
  auto g = testing::drive_laps<SE2>(2, 0, 1);
  g.problem.closures.clear();
  const RobustResult result = solve(g.problem);
  EXPECT_TRUE(result.converged) << result.message;
  expect_finite(g.problem, result);
  EXPECT_LT(testing::largest_error<SE2>(result.values, g.problem.initial), 1e-6);
}

TEST_P(ComparisonInput, OnlyLies) {
  auto g = testing::drive_laps<SE2>(3, 8, 6);
  std::vector<ContinuousFactorPtr> lies;
  for (std::size_t k = 0; k < g.truth.size(); ++k) {
    if (!g.truth[k]) lies.push_back(g.problem.closures[k]);
  }
  g.problem.closures = lies;
  expect_finite(g.problem, solve(g.problem));
}

TEST_P(ComparisonInput, OdometryWithAGapThatClosuresBridge) {
  auto g = testing::drive_laps<SE2>(3, 0, 1);
  g.problem.trusted.erase(g.problem.trusted.begin() + 20);
  const RobustResult result = solve(g.problem);
  expect_finite(g.problem, result);
  EXPECT_LT(testing::largest_error<SE2>(result.values, g.poses), 0.5);
}

TEST_P(ComparisonInput, TwoPartsAreSaidToBeUnderConstrained) {
  auto g = testing::drive_laps<SE2>(2, 0, 1);
  g.problem.trusted.erase(g.problem.trusted.begin() + 20);
  g.problem.closures.clear();
  g.problem.initial.update(testing::pose(3), SE2(1, 2, 0.1));  // not at the optimum already
  const RobustResult result = solve(g.problem);
  expect_finite(g.problem, result);
  EXPECT_FALSE(result.converged);
  EXPECT_NE(result.message.find("x"), std::string::npos) << result.message;
}

TEST_P(ComparisonInput, AMissingValueIsAnError) {
  auto g = testing::drive_laps<SE2>(2, 2, 1);
  g.problem.initial.erase(testing::pose(3));
  EXPECT_THROW(solve(g.problem), Error);
}

TEST_P(ComparisonInput, TheSameClosureTwice) {
  auto g = testing::drive_laps<SE2>(3, 3, 1);
  g.problem.closures.push_back(g.problem.closures.front());
  g.problem.closures.push_back(g.problem.closures.back());
  expect_finite(g.problem, solve(g.problem));
}

INSTANTIATE_TEST_SUITE_P(Methods, ComparisonInput,
                         ::testing::Values("lm", "gnc", "gnc-gm", "dcs", "switchable",
                                           "max-mixture", "consistency-gnc"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace hybrid
