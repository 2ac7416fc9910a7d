// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/closure_agreement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/core/error.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/pose_graph_worlds.h"

namespace hybrid {
namespace {

constexpr worlds::Sigmas kNoise{0.05, 0.02};

/// A town of streets, with its odometry and its closures apart, and what a solver makes of them.
struct Town {
  RobustProblem problem;  // the odometry is trusted
  std::vector<bool> accepted;
  Values truth;

  explicit Town(unsigned seed, int poses = 800) : random(seed) {
    const worlds::World world = worlds::town(poses, 15, 0.3, kNoise, seed);
    truth = world.truth;
    for (const ContinuousFactorPtr& factor : to_factors(world.graph, world.truth)) {
      const auto& keys = factor->keys();
      if (keys.size() == 2 && keys[1].index() - keys[0].index() > 1) {
        problem.closures.push_back(factor);
        accepted.push_back(true);
      } else {
        problem.trusted.push_back(factor);
      }
    }
  }

  std::size_t poses() const { return truth.size(); }

  void close(std::size_t a, std::size_t b, const SE2& z, bool accept) {
    const Noise noise =
        Noise::diagonal(Eigen::Vector3d(kNoise.translation, kNoise.translation, kNoise.rotation));
    problem.closures.push_back(std::make_shared<BetweenSE2>(Key('x', a), Key('x', b), z, noise));
    accepted.push_back(accept);
  }

  std::size_t below(std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  }
  double uniform(double most) {
    return std::uniform_real_distribution<double>(-most, most)(random);
  }

  /// Rejected closures that are false: single ones, or passages of `length` that agree.
  void close_wrongly(int count, std::size_t length = 1) {
    for (int i = 0; i < count; ++i) {
      const std::size_t a = below(poses() - length), b = below(poses() - length);
      if (std::max(a, b) - std::min(a, b) < 2 * length) continue;
      const SE2 offset(uniform(3), uniform(3), uniform(M_PI));
      const auto at = [&](std::size_t k) { return truth.at<SE2>(Key('x', k)); };
      for (std::size_t k = 0; k < length; ++k) {
        const SE2 z = at(a + k).between(at(a)) * offset * at(b).between(at(b + k));
        close(a + k, b + k, z, false);
      }
    }
  }

  ClosureAgreement agreement(const Values& start) const {
    const HybridGraph graph(factors_in_force(problem, accepted));
    const Values values = levenberg_marquardt(graph, {start, {}}).values;
    return agreement_of_closures(problem, values, accepted);
  }
  ClosureAgreement agreement() const { return agreement(truth); }

  std::mt19937_64 random;
};

TEST(ClosureAgreement, OfARightMapIsOne) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const ClosureAgreement found = Town(seed).agreement();
    EXPECT_GT(found.agreeing, 20u) << seed;
    EXPECT_EQ(found.rivals, 0u) << seed;
    EXPECT_LE(found.alone, 2u) << seed;
  }
}

TEST(ClosureAgreement, IsNotSpoiltByRejectedClosuresThatAgreeWithNothing) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Town town(seed);
    town.close_wrongly(1000);
    const ClosureAgreement found = town.agreement();
    EXPECT_GT(found.ratio, 0.9) << seed << ": " << found.rivals << " rivals";
  }
}

TEST(ClosureAgreement, IsNotSpoiltByAPlaceThatIsMistakenOnce) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Town town(seed);
    town.close_wrongly(40, 20);
    const ClosureAgreement found = town.agreement();
    EXPECT_GT(found.ratio, 0.9) << seed << ": " << found.rivals << " rivals";
  }
}

/// The second half of the path is turned about where it begins, and held there by one false
/// closure; all true ones between the halves are rejected.
TEST(ClosureAgreement, FindsAMapThatIsTornBetweenItsHalves) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Town town(seed);
    const std::size_t middle = town.poses() / 2;
    for (std::size_t k = 0; k < town.accepted.size(); ++k) {
      const auto& keys = town.problem.closures[k]->keys();
      town.accepted[k] = (keys[0].index() < middle) == (keys[1].index() < middle);
    }
    const SE2 bend = SE2(2, 1, 0.5);
    Values wrong;
    for (std::size_t k = 0; k < town.poses(); ++k) {
      const SE2 x = town.truth.at<SE2>(Key('x', k));
      wrong.insert(Key('x', k), k < middle ? x : bend * x);
    }
    const SE2 jump = wrong.at<SE2>(Key('x', middle - 1)).between(wrong.at<SE2>(Key('x', middle)));
    auto& odometry = town.problem.trusted;
    odometry.erase(odometry.begin() + std::ptrdiff_t(middle) - 1);
    town.close(middle - 1, middle, jump, true);
    const ClosureAgreement found = town.agreement(wrong);
    EXPECT_LT(found.ratio, 0.9) << seed << ": " << found.rivals << " rivals";
    ASSERT_FALSE(found.rival_closures.empty()) << seed;
    EXPECT_FALSE(town.accepted[found.rival_closures.front()]) << seed;
  }
}

/// Two laps of a circle. False closures say that places a third of a lap apart are one: between any
/// two of them the way is the same at both ends, so that they agree with each other.
TEST(ClosureAgreement, IsNotSpoiltByRejectedClosuresThatOdometryRefutes) {
  constexpr std::size_t kLap = 60, kShift = 17;
  Town town(1, 10);
  town.problem = {};
  town.accepted.clear();
  town.truth = {};
  const Noise noise = Noise::diagonal(Eigen::Vector3d(0.02, 0.02, 0.005));
  const SE2 step(0.5, 0, 2 * M_PI / kLap);
  SE2 pose;
  for (std::size_t k = 0; k < 2 * kLap; ++k, pose = pose * step) {
    town.truth.insert(Key('x', k), pose);
    if (k == 0)
      town.problem.trusted.push_back(std::make_shared<Prior<SE2>>(Key('x', 0), pose, noise));
    if (k == 0) continue;
    const SE2 error(0.02 * town.uniform(1.7), 0.02 * town.uniform(1.7), 0.005 * town.uniform(1.7));
    town.problem.trusted.push_back(
        std::make_shared<BetweenSE2>(Key('x', k - 1), Key('x', k), step * error, noise));
  }
  for (std::size_t k = 0; k < kLap; k += 4) town.close(k, k + kLap, SE2(), true);
  for (std::size_t k = 0; k + kShift < 2 * kLap; k += 7) {
    town.close(k, k + kShift, SE2(0.1, 0.1, 0.05), false);
  }
  const ClosureAgreement found = town.agreement();
  EXPECT_GE(found.agreeing, 3u);
  EXPECT_EQ(found.rivals, 0u);
  EXPECT_GE(found.alone, 3u);
}

TEST(ClosureAgreement, IsNoNumberWithoutClosures) {
  Town town(1, 100);
  town.problem.closures.clear();
  town.accepted.clear();
  const ClosureAgreement found = town.agreement();
  EXPECT_TRUE(std::isnan(found.ratio));
  EXPECT_TRUE(found.stretches.empty());
  town.accepted.push_back(true);
  EXPECT_THROW(town.agreement(), Error);
}

}  // namespace
}  // namespace hybrid
