// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/null_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libhybrid/factors/bearing.h"
#include "libhybrid/factors/range.h"
#include "libhybrid/hybrid/mixture.h"
#include "tests/support/dense_system.h"
#include "tests/support/random.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using Eigen::Vector2d;
using testing::pose;
using testing::Random;

std::vector<Key> keys_of(const std::vector<FreeVariable>& variables) {
  std::vector<Key> keys;
  for (const FreeVariable& variable : variables) keys.push_back(variable.key);
  std::sort(keys.begin(), keys.end());
  return keys;
}

TEST(FreeVariables, OneRangeLeavesThePointFreeAcrossItsLineInAnyDirection) {
  for (double angle : {0.0, 0.25 * M_PI, 0.5 * M_PI, 1.0, 2.0, M_PI, 4.0}) {
    const Vector2d along(std::cos(angle), std::sin(angle));
    HybridGraph graph;
    graph.emplace<Prior<Vector2d>>(Key('x', 0), Vector2d(0, 0), Noise::isotropic(2, 0.1));
    graph.emplace<Range<Vector2d, Vector2d>>(Key('x', 0), Key('l', 0), 1.0,
                                             Noise::isotropic(1, 0.1));
    Estimate estimate;
    estimate.values.insert(Key('x', 0), Vector2d(0, 0));
    estimate.values.insert(Key('l', 0), along);
    const auto free = free_variables(graph, estimate);
    ASSERT_EQ(free.size(), 1u) << angle;
    EXPECT_EQ(free[0].key, Key('l', 0));
    ASSERT_EQ(free[0].directions.cols(), 1);
    EXPECT_NEAR(std::abs(free[0].directions.col(0).dot(along)), 0.0, 1e-7);
  }
}

TEST(FreeVariables, ARejectedMeasurementDeterminesNothing) {
  HybridGraph graph;
  graph.emplace<Prior<Vector2d>>(Key('l', 0), Vector2d(0, 0), Noise::isotropic(2, 0.1),
                                 Loss::tukey());
  Estimate estimate;
  estimate.values.insert(Key('l', 0), Vector2d(10, 0));
  const auto free = free_variables(graph, estimate);
  ASSERT_EQ(free.size(), 1u);
  EXPECT_EQ(free[0].directions.cols(), 2);
  estimate.values.update(Key('l', 0), Vector2d(0.1, 0.0));
  EXPECT_TRUE(free_variables(graph, estimate).empty());
}

/// Poses with priors on some, landmarks with ranges and bearings, parts of it free.
struct Scene {
  HybridGraph graph;
  Estimate estimate;
};

/// The scene of a seed as seen in a map turned and moved by T.
Scene scene(unsigned seed, const SE2& T) {
  Random random(seed);
  Scene s;
  std::vector<SE2> poses;
  std::vector<Vector2d> points;
  for (int i = 0; i < 6; ++i) {
    poses.push_back(random.value<SE2>());
    s.estimate.values.insert(pose(i), T * poses.back());
  }
  for (int j = 0; j < 6; ++j) {
    points.push_back(random.vector<2>(5.0));
    s.estimate.values.insert(Key('l', j), Vector2d(T * points.back()));
    // A point without any factor is in no problem.
    s.graph.emplace<Range<SE2, Vector2d>>(pose(j), Key('l', j), 1.0, Noise::isotropic(1, 0.1));
  }
  const auto chance = [&](double p) { return random.uniform(0.0, 1.0) < p; };
  for (int i = 0; i < 6; ++i) {
    if (chance(0.2)) {
      s.graph.emplace<Prior<SE2>>(pose(i), T * poses[i], Noise::isotropic(3, 0.01));
    }
    if (i > 0 && chance(0.7)) {
      s.graph.emplace<Between<SE2>>(pose(i - 1), pose(i), poses[i - 1].between(poses[i]),
                                    random.noise(3));
    }
    for (int j = 0; j < 6; ++j) {
      if (chance(0.15)) {
        s.graph.emplace<Range<SE2, Vector2d>>(pose(i), Key('l', j), 1.0, Noise::isotropic(1, 0.1));
      }
      if (chance(0.1)) {
        s.graph.emplace<Bearing2>(pose(i), Key('l', j), Bearing2::Angles(0.1),
                                  Noise::isotropic(1, 0.01));
      }
    }
  }
  return s;
}

/// How many null vectors a dense decomposition finds.
int dense_nullity(const Scene& s) {
  Eigen::MatrixXd J = testing::DenseSystem(s.graph, s.estimate).J;
  for (int c = 0; c < J.cols(); ++c) {
    if (J.col(c).norm() > 0.0) J.col(c).normalize();
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(J);
  qr.setThreshold(1e-11);
  return static_cast<int>(J.cols() - qr.rank());
}

TEST(FreeVariables, AreTheSameInAnyFrame) {
  int free_scenes = 0, fixed_scenes = 0, mixed = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Scene s = scene(seed, SE2());
    const auto free = free_variables(s.graph, s.estimate);
    EXPECT_EQ(free.empty(), dense_nullity(s) == 0) << seed;
    for (double angle : {0.5, M_PI / 2, 3.0}) {
      const SE2 T(100.0, -30.0, angle);
      const Scene turned = scene(seed, T);
      const auto others = free_variables(turned.graph, turned.estimate);
      ASSERT_EQ(keys_of(free), keys_of(others)) << seed;
      for (const FreeVariable& variable : free) {
        const auto other = std::find_if(others.begin(), others.end(), [&](const FreeVariable& v) {
          return v.key == variable.key;
        });
        // The tangent of a pose turns with it, that of a point stays with the map.
        Eigen::MatrixXd expected = variable.directions;
        if (expected.rows() == 2) expected = T.rotation().matrix() * expected;
        ASSERT_EQ(expected.cols(), other->directions.cols()) << seed << " " << variable.key;
        EXPECT_LT(
            (expected * expected.transpose() - other->directions * other->directions.transpose())
                .norm(),
            1e-6)
            << seed << " " << variable.key;
      }
    }
    free_scenes += !free.empty();
    fixed_scenes += free.empty();
    mixed += !free.empty() && free.size() < 12;
  }
  EXPECT_GT(free_scenes, 50);
  EXPECT_GT(fixed_scenes, 10);
  EXPECT_GT(mixed, 30);
}

TEST(FreeVariables, OfSeveralPartsWithoutFrameAreAll) {
  auto s = testing::simulate_loops<SE2>(30, 20, 0.05, 7);
  s.graph.remove(s.graph.continuous().handle(0));
  for (int i = 100; i < 110; ++i) {
    s.initial.values.insert(pose(i), SE2(i, 0, 0));
    if (i > 100) {
      s.graph.emplace<BetweenSE2>(pose(i - 1), pose(i), SE2(1, 0, 0), Noise::unit(3));
    }
  }
  for (int j = 0; j < 5; ++j) {
    s.initial.values.insert(Key('l', j), Vector2d(j, 3.0));
    s.graph.emplace<Bearing2>(pose(j), Key('l', j), Bearing2::Angles(0.3),
                              Noise::isotropic(1, 0.01));
  }
  EXPECT_EQ(free_variables(s.graph, s.initial).size(), 45u);
  // With both parts held, only the points of one bearing are left.
  s.graph.emplace<Prior<SE2>>(pose(3), SE2(), Noise::unit(3));
  s.graph.emplace<Prior<SE2>>(pose(103), SE2(), Noise::unit(3));
  const auto free = free_variables(s.graph, s.initial);
  EXPECT_EQ(keys_of(free),
            (std::vector<Key>{Key('l', 0), Key('l', 1), Key('l', 2), Key('l', 3), Key('l', 4)}));
  for (const FreeVariable& variable : free) EXPECT_EQ(variable.directions.cols(), 1);
}

TEST(FreeVariables, WeakComponentsCountAsTheSolverTakesThem) {
  const DiscreteKey choice{Key('d', 0), 2};
  HybridGraph graph;
  graph.emplace<Prior<SE2>>(pose(0), SE2(), Noise::unit(3));
  const auto motion =
      std::make_shared<BetweenSE2>(pose(0), pose(1), SE2(1, 0, 0), Noise::isotropic(3, 0.1));
  graph.add(std::make_shared<Mixture>(
      std::vector<DiscreteKey>{choice},
      std::vector<MixtureComponent>{{motion, 0.0, true}, {nullptr, 0.0, true}}));
  Estimate estimate;
  estimate.values.insert(pose(0), SE2());
  estimate.values.insert(pose(1), SE2(1, 0, 0));
  estimate.assignment.set(choice.key, 0);
  EXPECT_TRUE(free_variables(graph, estimate, WeakComponents::kUncoupled).empty());
  EXPECT_TRUE(free_variables(graph, estimate, WeakComponents::kCoupled).empty());
  estimate.assignment.set(choice.key, 1);
  EXPECT_EQ(keys_of(free_variables(graph, estimate)), std::vector<Key>{pose(1)});
}

}  // namespace
}  // namespace hybrid
