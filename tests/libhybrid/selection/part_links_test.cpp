// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/part_links.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/position.h"
#include "libhybrid/factors/prior.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;

constexpr int kPoses = 60;  // of a robot, 1.5 rounds of a circle

Key pose(int robot, int k) {
  return {'x', static_cast<std::uint64_t>(1000 * robot + k)};
}

/// Robots on one circle, that begin at different places of it. Their odometry is all that is
/// trusted; initial values have every robot begin at the origin.
struct Robots {
  RobustProblem problem;
  std::vector<bool> truth;
  Values true_poses;

  explicit Robots(int count, std::uint64_t seed = 1) : random(seed) {
    for (int robot = 0; robot < count; ++robot) {
      SE2 estimate;
      for (int k = 0; k < kPoses; ++k) {
        true_poses.insert(pose(robot, k), at(9 * robot + k));
        if (k > 0) {
          const SE2 step = seen(pose(robot, k - 1), pose(robot, k));
          add(problem.trusted, pose(robot, k - 1), pose(robot, k), step);
          estimate = estimate * step;
        }
        problem.initial.insert(pose(robot, k), estimate);
      }
    }
    problem.trusted.push_back(
        std::make_shared<Prior<SE2>>(pose(0, 0), SE2(), Noise::isotropic(3, 1e-3)));
  }

  void close(Key a, Key b) {
    add(problem.closures, a, b, seen(a, b));
    truth.push_back(true);
  }
  void close_wrongly(Key a, Key b) {
    const double x = random.uniform(-6, 6), y = random.uniform(-6, 6);
    add(problem.closures, a, b, SE2(x, y, random.uniform(-3, 3)));
    truth.push_back(false);
  }
  /// So many true and false ones between two robots, the false ones first.
  void meet(int a, int b, int right, int wrong) {
    for (int i = 0; i < wrong + right; ++i) {
      const Key from = pose(a, random.below(kPoses)), to = pose(b, random.below(kPoses));
      i < wrong ? close_wrongly(from, to) : close(from, to);
    }
  }

  /// The largest error of a pose, in the frame of the first one.
  double error(const Values& values) const {
    const SE2 origin = true_poses.at<SE2>(pose(0, 0));
    double largest = 0.0;
    for (const Key key : true_poses.keys()) {
      const SE2 expected = origin.between(true_poses.at<SE2>(key));
      largest =
          std::max(largest, (values.at<SE2>(key).translation() - expected.translation()).norm());
    }
    return largest;
  }

  Random random;

 private:
  static SE2 at(int k) {
    const double angle = k * 2.0 * M_PI / 40;
    return {5 * std::cos(angle), 5 * std::sin(angle), angle + M_PI / 2};
  }
  SE2 seen(Key a, Key b) {
    const double x = random.normal(0.02), y = random.normal(0.02);
    return true_poses.at<SE2>(a).between(true_poses.at<SE2>(b)) * SE2(x, y, random.normal(0.01));
  }
  static void add(std::vector<ContinuousFactorPtr>& factors, Key a, Key b, const SE2& z) {
    factors.push_back(
        std::make_shared<BetweenSE2>(a, b, z, Noise::diagonal(Eigen::Vector3d(0.02, 0.02, 0.01))));
  }
};

/// Joins the parts, solves, and compares the decisions with the truth.
void expect_right(const Robots& robots, std::size_t links, double largest_error = 0.3) {
  const JoinedParts joined = join_parts(robots.problem);
  ASSERT_EQ(joined.links.size(), links);
  const RobustResult result = select_closures(joined.problem);
  for (std::size_t k = 0; k < joined.closures.size(); ++k) {
    EXPECT_EQ(result.decisions[k].accepted(), robots.truth[joined.closures[k]])
        << joined.closures[k];
  }
  for (const ClosureDecision& link : judge_links(joined, result)) {
    EXPECT_TRUE(link.accepted());
    EXPECT_GT(link.inlier_probability, 0.99);
  }
  for (const PartLink& link : joined.links) {
    EXPECT_TRUE(robots.truth[link.closure]) << link.closure;
  }
  EXPECT_LT(robots.error(result.values), largest_error);
}

TEST(JoinParts, TakesWhatAgreesAndNotWhatComesFirst) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Robots robots(2, seed);
    robots.meet(0, 1, 12, 12);
    expect_right(robots, 1);
    std::reverse(robots.problem.closures.begin(), robots.problem.closures.end());
    std::reverse(robots.truth.begin(), robots.truth.end());
    expect_right(robots, 1);
  }
}

TEST(JoinParts, OfThreeRobots) {
  Robots robots(3);
  for (int robot = 0; robot < 3; ++robot) {
    for (int k = 0; k < 10; ++k) robots.close(pose(robot, k), pose(robot, k + 40));
  }
  robots.meet(0, 1, 3, 20);  // these two are joined by way of the third
  robots.meet(0, 2, 8, 20);
  robots.meet(1, 2, 8, 20);
  expect_right(robots, 2);
}

TEST(JoinParts, OnePartStaysAsItIs) {
  Robots robots(1);
  robots.close(pose(0, 0), pose(0, 40));
  const JoinedParts joined = join_parts(robots.problem);
  EXPECT_TRUE(joined.links.empty());
  EXPECT_EQ(joined.problem.closures, robots.problem.closures);
  EXPECT_EQ(joined.candidates, 0u);
  EXPECT_TRUE(judge_links(joined, select_closures(joined.problem)).empty());
}

TEST(JoinParts, OneClosureAloneIsTrustedAndNotCheckable) {
  Robots robots(2);
  robots.close(pose(0, 3), pose(1, 5));
  const JoinedParts joined = join_parts(robots.problem);
  ASSERT_EQ(joined.links.size(), 1u);
  EXPECT_EQ(joined.links[0].agreeing, 1u);
  const auto links = judge_links(joined, select_closures(joined.problem));
  EXPECT_EQ(links.at(0).status, ClosureStatus::kTrusted);
  EXPECT_FALSE(links[0].checkable);
}

TEST(JoinParts, WhereNothingAgreesNoneIsAccepted) {
  Robots robots(2);
  robots.meet(0, 1, 1, 8);
  const JoinedParts joined = join_parts(robots.problem);
  ASSERT_EQ(joined.links.size(), 1u);
  EXPECT_EQ(joined.candidates, 9u);
  const auto links = judge_links(joined, select_closures(joined.problem));
  EXPECT_EQ(links.at(0).status, ClosureStatus::kTrusted);
}

/// Parts that are both measured in the map have a common frame: all closures between them are in
/// question.
TEST(JoinParts, PartsInTheMapNeedNoLink) {
  Robots robots(2);
  for (const int k : {0, 12, 30}) {
    const SE2 origin = robots.true_poses.at<SE2>(pose(0, 0));
    const SE2 there = origin.between(robots.true_poses.at<SE2>(pose(1, k)));
    robots.problem.trusted.push_back(std::make_shared<Position2>(
        pose(1, k), Eigen::Vector2d(there.translation()), Noise::isotropic(2, 0.1)));
  }
  robots.meet(0, 1, 1, 8);
  EXPECT_TRUE(join_parts(robots.problem).links.empty());
}

/// Positions in the map that may be false place parts, and the rest of them are closures.
TEST(JoinParts, PositionsThatAgreePlaceParts) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Robots robots(2, seed);
    robots.problem.trusted.pop_back();  // the prior on the first pose
    const SE2 origin = robots.true_poses.at<SE2>(pose(0, 0));
    for (int robot = 0; robot < 2; ++robot) {
      for (int k = 0; k < kPoses; k += 4) {
        const SE2 there = origin.between(robots.true_poses.at<SE2>(pose(robot, k)));
        const bool is_false = k % 12 == 8;
        const Eigen::Vector2d off = is_false ? Eigen::Vector2d(20 - k, 30) : Eigen::Vector2d(0, 0);
        robots.problem.closures.push_back(std::make_shared<Position2>(
            pose(robot, k), there.translation() + off, Noise::isotropic(2, 0.1)));
        robots.truth.push_back(!is_false);
      }
    }
    const JoinedParts joined = join_parts(robots.problem);
    ASSERT_EQ(joined.links.size(), 4u);  // two positions for each part
    EXPECT_EQ(joined.candidates, 0u);
    for (const PartLink& link : joined.links) {
      EXPECT_TRUE(link.to_map);
      EXPECT_EQ(link.agreeing, 9u);
      EXPECT_EQ(link.candidates, 10u);
    }
    expect_right(robots, 4);
  }
}

}  // namespace
}  // namespace hybrid
