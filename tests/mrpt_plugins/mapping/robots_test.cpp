// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Several robots in one map.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>

#include "libhybrid/core/error.h"
#include "tests/mrpt_plugins/plugins/beacon_world.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;
using testing::BeaconWorld;

constexpr int kKeyframes = 40;
constexpr int kAhead = 12;  // keyframes of the second robot, on the way of the first

/// Two robots that drive one way, the second ahead of the first. It knows where it starts to half
/// a metre.
class TwoRobots : public ::testing::TestWithParam<bool> {
 protected:
  Mapper mapper(const std::string& mode = "incremental") {
    IniFile ini("[solver]\nmode = " + mode, "test.ini");
    RobotOptions first{"one", -101, read_motion_options(ini), {}, {}}, second = first;
    second.name = "two";
    second.id = -102;
    Eigen::VectorXd variances = Eigen::VectorXd::Constant(GetParam() ? 6 : 3, 0.25);
    second.motion.start = KnownStart{to_isometry(start()), Eigen::MatrixXd(variances.asDiagonal())};
    return {{first, second},
            {make_plugin("BearingRangeKnownIds", ini)},
            make_backend(ini.section("solver")),
            GetParam()};
  }
  /// Off by what the second robot does not know of its start.
  CPose3D start() const {
    return world.true_pose(kAhead) + CPose3D(0.4, -0.3, GetParam() ? 0.2 : 0.0, 0.2, 0, 0);
  }
  /// What one robot sees of the other at its keyframe i, `ahead` of it on the way.
  void see(Keyframe& keyframe, int i, int other, std::int64_t id) {
    DetectionFrame frame;
    frame.is_3d = GetParam();
    Detection d;
    const auto p = world.true_pose(other).translation();
    world.true_pose(i).sphericalCoordinates(p, d.range, d.yaw, d.pitch);
    d.range += world.gauss(0.02);
    d.yaw += world.gauss(0.01);
    d.pitch = GetParam() ? d.pitch + world.gauss(0.01) : 0.0;
    d.id = id;
    d.covariance.diagonal() << 4e-4, 1e-4, GetParam() ? 1e-4 : 0.0;
    frame.detections = {d};
    keyframe.robots = {frame};
  }
  Keyframe keyframe_of_second(int i, bool with_landmarks) {
    Keyframe out =
        with_landmarks ? world.with_detections(kAhead + i, true) : world.keyframe(kAhead + i);
    if (i == 0) out.odometry.reset();
    out.robot = 1;
    out.time = i;
    return out;
  }
  /// Root mean square error of the positions of a robot.
  double error(const MapResult& result, std::size_t robot) const {
    double sum = 0;
    const auto& keyframes = result.robots.at(robot).keyframes;
    for (std::size_t k = 0; k < keyframes.size(); ++k) {
      const int i = static_cast<int>(k) + (robot == 1 ? kAhead : 0);
      sum += std::pow(result.trajectory[keyframes[k]].pose.distanceTo(world.true_pose(i)), 2);
    }
    return std::sqrt(sum / static_cast<double>(keyframes.size()));
  }

  BeaconWorld world{GetParam()};
};
INSTANTIATE_TEST_SUITE_P(PlaneAndSpace, TwoRobots, ::testing::Bool(),
                         [](const auto& info) { return info.param ? "Space" : "Plane"; });

TEST_P(TwoRobots, MakeOneMapOfLandmarks) {
  for (const char* mode : {"incremental", "batch\nsolve_every = 1"}) {
    SCOPED_TRACE(mode);
    world = BeaconWorld(GetParam());
    Mapper map = mapper(mode);
    for (int i = 0; i < kKeyframes; ++i) {
      map.add(world.with_detections(i, true));
      map.add(keyframe_of_second(i, true));
    }
    map.finish();
    const MapResult result = map.result();
    ASSERT_EQ(result.robots.size(), 2U);
    EXPECT_EQ(result.robots[1].name, "two");
    EXPECT_EQ(result.robots[1].keyframes[3], 7U);
    EXPECT_EQ(result.trajectory.size(), 2U * kKeyframes);
    EXPECT_EQ(result.landmarks.size(), world.beacons.size());
    EXPECT_LT(error(result, 0), 0.1);
    EXPECT_LT(error(result, 1), 0.1);
  }
}

TEST_P(TwoRobots, AreTiedByWhatTheySeeOfEachOther) {
  Mapper map = mapper();
  for (int i = 0; i < kKeyframes; ++i) {
    Keyframe first = world.with_detections(i, true);
    see(first, i, kAhead + i, -102);
    Keyframe second = keyframe_of_second(i, false);
    see(second, kAhead + i, i, -101);
    map.add(first);
    map.add(second);
  }
  map.finish();
  const MapResult result = map.result();
  EXPECT_LT(error(result, 0), 0.1);
  EXPECT_LT(error(result, 1), 0.1);
  // The first of the second robot is before its way begins, the last of the first one after it
  // ends.
  EXPECT_EQ(map.statistics().at("robot_sightings"), 2.0 * kKeyframes - 2);
}

TEST_P(TwoRobots, StartWhereTheyAreSaidToUntilThatIsGivenUp) {
  Mapper map = mapper();
  for (int i = 0; i < kKeyframes; ++i) {
    map.add(world.with_detections(i, true));
    map.add(keyframe_of_second(i, true));
  }
  const auto starts = [&] { return map.backend().graph().continuous().size(); };
  const std::size_t factors = starts();
  map.forget_start(1);
  map.finish();
  EXPECT_EQ(starts(), factors);  // a wide prior stands in for it
  EXPECT_LT(error(map.result(), 1), 0.1);
}

TEST_P(TwoRobots, NeedAMapThatKeepsTheirPoses) {
  EXPECT_THROW(mapper("fixed_lag\nlag = 20"), SettingsError);
  EXPECT_THROW(mapper("filter"), SettingsError);
}

}  // namespace
}  // namespace hybrid
