// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/fixes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/mrpt_plugins/plugins/beacon_world.h"

namespace hybrid {
namespace {

using testing::make_mapper;
using World = testing::BeaconWorld;

const LocalFrame kEarth({36.7, -4.5, 60});

/// A robot on a circle of 4 m is too small for fixes of metres: these are of ambiguities fixed.
Keyframe keyframe_with_fix(World& world, int i, const Eigen::Vector3d& error) {
  Keyframe out = world.keyframe(i);
  const auto p = world.true_pose(i).composePoint({0.2, 0.1, 0.5});
  LoggedFix fix;
  fix.fix.time = i;
  fix.fix.row = static_cast<std::size_t>(i);
  fix.fix.sigma = 0.05;
  fix.fix.antenna = {0.2, 0.1, 0.5};
  const Eigen::Isometry3d T(Eigen::Translation3d(120, -40, 3) *
                            Eigen::AngleAxisd(-2, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d noise(world.gauss(0.02), world.gauss(0.02), world.gauss(0.02));
  fix.place = kEarth.to_geodetic(T * Eigen::Vector3d(p.x, p.y, p.z) + noise + error);
  out.fixes = {fix};
  return out;
}

class FixesInMap : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(PlaneAndSpace, FixesInMap, ::testing::Bool());

/// Root mean square of the error of the path after the best motion between the two.
double path_error(const MapResult& result, const World& world) {
  Eigen::Matrix3Xd a(3, result.trajectory.size()), b = a;
  for (std::size_t i = 0; i < result.trajectory.size(); ++i) {
    const auto p = result.trajectory[i].pose.translation();
    const auto q = world.true_pose(static_cast<int>(i)).translation();
    a.col(static_cast<Eigen::Index>(i)) << p.x, p.y, p.z;
    b.col(static_cast<Eigen::Index>(i)) << q.x, q.y, q.z;
  }
  const Eigen::Matrix4d T = Eigen::umeyama(a, b, false);
  return std::sqrt(
      ((T.topLeftCorner<3, 3>() * a).colwise() + T.topRightCorner<3, 1>() - b).squaredNorm() /
      static_cast<double>(a.cols()));
}

TEST_P(FixesInMap, HoldAPathThatDrifts) {
  const auto error_with = [&](bool fixes) {
    World world(GetParam());
    Mapper mapper = make_mapper("Fixes", GetParam());
    for (int i = 0; i < 300; ++i) {
      Keyframe keyframe = keyframe_with_fix(world, i, Eigen::Vector3d::Zero());
      if (!fixes) keyframe.fixes.clear();
      mapper.add(keyframe);
    }
    mapper.finish();
    return path_error(mapper.result(), world);
  };
  EXPECT_LT(error_with(true), 0.06);
  EXPECT_GT(error_with(false), 0.1);
}

TEST_P(FixesInMap, FalseOnesAreFoundAndHarmNothing) {
  World world(GetParam());
  Mapper mapper = make_mapper("Fixes", GetParam());
  for (int i = 0; i < 200; ++i) {
    const bool wrong = i % 20 == 11;
    mapper.add(keyframe_with_fix(world, i, {wrong ? 120.0 : 0.0, wrong ? -200.0 : 0.0, 0}));
  }
  mapper.finish();
  const MapResult result = mapper.result();
  ASSERT_TRUE(result.datum);
  ASSERT_EQ(result.fixes.size(), 199U);  // the first waits for the second, which confirms it
  for (std::size_t i = 0; i < result.fixes.size(); ++i) {
    const bool wrong = (i + 1) % 20 == 11;
    ASSERT_TRUE(result.fixes[i].mode);
    EXPECT_EQ(*result.fixes[i].mode == FixMode::kFalse, wrong) << i;
    EXPECT_EQ(result.fixes[i].probabilities[2] > 0.5, wrong) << i;
  }
  EXPECT_LT(path_error(result, world), 0.08);
}

}  // namespace
}  // namespace hybrid
