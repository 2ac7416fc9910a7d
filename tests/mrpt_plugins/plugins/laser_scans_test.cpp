// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "mrpt_plugins/plugins/laser_scans.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "tests/mrpt_plugins/plugins/beacon_world.h"
#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

/// A drive of two rounds along the ring of corridors, a keyframe every half metre and a scan
/// between two of them, by noisy odometry.
class RingDrive {
 public:
  /// `noise`: standard deviations of odometry, per step of 0.25 m, in 1 cm and 0.01 rad.
  explicit RingDrive(unsigned seed, double noise = 1) : random_(seed), scale_(noise) {}

  Keyframe keyframe(std::size_t i) {
    Keyframe out;
    out.row = i;
    out.time = double(i);
    const SE2& truth = way[2 * i];
    if (i > 0) {
      SE2 motion;
      SE2 middle;
      for (std::size_t k = 2 * i - 2; k < 2 * i; ++k) {
        const SE2 step =
            way[k].between(way[k + 1]) * SE2(0.01 * error(), 0.005 * error(), 0.01 * error());
        if (k == 2 * i - 1) middle = step.inverse();
        motion = motion * step;
      }
      OdometryIncrement odometry;
      odometry.mean = mrpt::poses::CPose3D(motion.x(), motion.y(), 0, motion.angle(), 0, 0);
      odometry.covariance.diagonal().setConstant(4e-4);
      out.odometry = odometry;
      LaserScan between = scan(way[2 * i - 1], out.time - 0.5);
      between.T_keyframe_robot = Eigen::Translation3d(middle.x(), middle.y(), 0) *
                                 Eigen::AngleAxisd(middle.angle(), Eigen::Vector3d::UnitZ());
      out.scans.push_back(between);
    }
    out.scans.push_back(scan(truth, out.time));
    return out;
  }

  std::vector<SE2> way = testing::way_around_ring(2, 0.25);

  /// A pose of the way, as a log of scans alone has it.
  Keyframe scan_alone(std::size_t i) {
    Keyframe out;
    out.row = i;
    out.time = double(i);
    out.scans.push_back(scan(way[i], out.time));
    return out;
  }

 private:
  double error() { return scale_ * noise_(random_); }
  LaserScan scan(const SE2& pose, double time) {
    LaserScan scan = plan_.scan(pose, 181, 0.015, random_);
    scan.time = time;
    return scan;
  }

  testing::FloorPlan plan_ = testing::ring();
  std::mt19937 random_;
  double scale_;
  std::normal_distribution<double> noise_;
};

struct Errors {
  double map = 0, odometry = 0;  // root mean square [m]
};

Errors errors_of(const MapResult& result, const RingDrive& drive) {
  Errors errors;
  for (std::size_t i = 0; i < result.trajectory.size(); ++i) {
    const SE2 truth = drive.way.front().between(drive.way[2 * i]);
    const auto& pose = result.trajectory[i].pose;
    const auto& dead = result.dead_reckoning[i].pose;
    errors.map += std::pow(pose.x() - truth.x(), 2) + std::pow(pose.y() - truth.y(), 2);
    errors.odometry += std::pow(dead.x() - truth.x(), 2) + std::pow(dead.y() - truth.y(), 2);
  }
  errors.map = std::sqrt(errors.map / double(result.trajectory.size()));
  errors.odometry = std::sqrt(errors.odometry / double(result.trajectory.size()));
  return errors;
}

Errors errors_of(const Mapper& mapper, const RingDrive& drive) {
  return errors_of(mapper.result(), drive);
}

/// Distance between a motion and the true one from pose `a` to pose `b` [m].
double error_of(const SE2& motion, const SE2& a, const SE2& b) {
  return (motion.translation() - a.between(b).translation()).norm();
}

class LaserScansIn : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(PlaneAndSpace, LaserScansIn, ::testing::Bool());

TEST_P(LaserScansIn, CloseTheLoopOfARing) {
  RingDrive drive(1);
  Mapper mapper = testing::make_mapper("LaserScans", GetParam());
  for (std::size_t i = 0; 2 * i < drive.way.size(); ++i) mapper.add(drive.keyframe(i));
  mapper.finish();
  EXPECT_GT(mapper.statistics().at("scan_closures_accepted"), 10);
  EXPECT_GT(mapper.measurements(), drive.way.size() / 2);
  const Errors errors = errors_of(mapper, drive);
  EXPECT_LT(errors.map, 0.15);
  EXPECT_LT(errors.map, 0.5 * errors.odometry);
}

TEST(LaserScans, ThoseOfARepeatedStampFromTwoPlacesAreNotOfTwoScanners) {
  RingDrive drive(1);
  Mapper mapper = testing::make_mapper("LaserScans", false);
  for (std::size_t i = 0; 2 * i < drive.way.size(); ++i) {
    Keyframe keyframe = drive.keyframe(i);
    for (LaserScan& scan : keyframe.scans) scan.time = keyframe.time;
    mapper.add(keyframe);
  }
  mapper.finish();
  EXPECT_LT(errors_of(mapper, drive).map, 0.15);
}

TEST_P(LaserScansIn, ScansBetweenKeyframesArePlacedByMatches) {
  RingDrive drive(1, 5);
  IniFile ini;
  const auto plugin = make_plugin("LaserScans", ini);
  const auto& follower = dynamic_cast<const ScanFollower&>(*plugin);
  Mapper mapper(read_motion_options(ini), {plugin}, make_backend(ini.section("solver")),
                GetParam());
  mapper.add(drive.keyframe(0));
  double by_scans = 0, by_odometry = 0;
  const std::size_t keyframes = 80;
  for (std::size_t i = 1; i < keyframes; ++i) {
    const Keyframe keyframe = drive.keyframe(i);
    mapper.add(keyframe);
    ASSERT_TRUE(follower.scan_motion());
    const ScanMotion motion = *follower.scan_motion();
    ASSERT_EQ(motion.T_keyframe_robot.size(), 2U);
    ASSERT_TRUE(motion.T_before_keyframe);
    const SE2 &before = drive.way[2 * i - 2], middle = drive.way[2 * i - 1],
              &now = drive.way[2 * i];
    const Eigen::Vector3d guess = keyframe.scans.front().T_keyframe_robot.translation();
    by_odometry += (guess.head<2>() - now.between(middle).translation()).norm() / keyframes;
    by_scans += error_of(motion.T_keyframe_robot.front(), now, middle) / keyframes;
    EXPECT_LT(error_of(*motion.T_before_keyframe, before, now), 0.15);
    EXPECT_NEAR(motion.T_keyframe_robot.back().x(), 0, 1e-12);
  }
  EXPECT_LT(by_scans, 0.02);
  EXPECT_LT(by_scans, 0.4 * by_odometry);
}

TEST(LaserScans, TheNoiseOfOdometryIsMeasured) {
  for (const double stated : {1e-4, 1.0}) {
    SCOPED_TRACE(stated);
    for (const double noise : {0.1, 3.0}) {
      RingDrive drive(3, noise);
      Mapper mapper = testing::make_mapper("LaserScans", false);
      for (std::size_t i = 0; 2 * i < drive.way.size(); ++i) {
        Keyframe keyframe = drive.keyframe(i);
        if (i > 0) keyframe.odometry->covariance.diagonal().setConstant(stated * stated);
        mapper.add(keyframe);
      }
      mapper.finish();
      EXPECT_LT(errors_of(mapper, drive).map, 0.15) << noise;
    }
  }
}

TEST(LaserScans, MapAloneWhereThereIsNoOdometry) {
  RingDrive drive(5);
  Mapper mapper = testing::make_mapper("LaserScans", false);
  for (std::size_t i = 0; i < drive.way.size(); ++i) mapper.add(drive.scan_alone(i));
  mapper.finish();
  EXPECT_GT(mapper.statistics().at("scan_closures_accepted"), 10);
  const MapResult result = mapper.result();
  double most = 0;
  for (std::size_t i = 0; i < drive.way.size(); ++i) {
    const SE2 truth = drive.way.front().between(drive.way[i]);
    const auto& pose = result.trajectory[i].pose;
    most = std::max(most, std::hypot(pose.x() - truth.x(), pose.y() - truth.y()));
  }
  EXPECT_LT(most, 0.5);
}

TEST(LaserScans, ClosuresAreToldWithTheirDecisions) {
  RingDrive drive(1);
  IniFile ini;
  const auto plugin = make_plugin("LaserScans", ini);
  Mapper mapper(read_motion_options(ini), {plugin}, make_backend(ini.section("solver")), false);
  for (std::size_t i = 0; 2 * i < drive.way.size(); ++i) mapper.add(drive.keyframe(i));
  mapper.finish();
  const std::vector<MeasuredClosure<SE2>> closures =
      dynamic_cast<const ScanFollower&>(*plugin).scan_closures();
  const std::size_t poses = mapper.result().trajectory.size();
  EXPECT_EQ(closures.size(), mapper.statistics().at("scan_closures"));
  double accepted = 0;
  for (const ScanClosureEstimate& closure : closures) {
    EXPECT_LT(closure.from, closure.to);
    EXPECT_LT(closure.to, poses);
    if (!closure.decision.accepted()) continue;
    ++accepted;
    EXPECT_GT(closure.decision.inlier_probability, 0.5);
    EXPECT_GT(closure.decision.margin, 0);
  }
  EXPECT_EQ(accepted, mapper.statistics().at("scan_closures_accepted"));
}

TEST(LaserScans, ThoseOfTwoRobotsAreNotMixed) {
  RingDrive drives[] = {RingDrive(1), RingDrive(2)};
  IniFile ini;
  RobotOptions one{"one", 1, read_motion_options(ini), {}, {}}, two = one;
  two.name = "two";
  two.id = 2;
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  start.translation().x() = 100;
  two.motion.start = KnownStart{start, Eigen::MatrixXd::Identity(3, 3) * 1e-6};
  Mapper mapper({one, two}, {make_plugin("LaserScans", ini)}, make_backend(ini.section("solver")),
                false);
  for (std::size_t i = 0; 2 * i < drives[0].way.size(); ++i) {
    for (std::size_t robot : {0, 1}) {
      Keyframe keyframe = drives[robot].keyframe(i);
      keyframe.robot = robot;
      mapper.add(keyframe);
    }
  }
  mapper.finish();
  const MapResult all = mapper.result();
  for (std::size_t robot : {0, 1}) {
    MapResult own;
    for (const std::size_t k : all.robots[robot].keyframes) {
      own.trajectory.push_back(all.trajectory[k]);
      own.trajectory.back().pose.x_incr(robot == 1 ? -100 : 0);
      own.dead_reckoning.push_back(all.dead_reckoning[k]);
    }
    EXPECT_LT(errors_of(own, drives[robot]).map, 0.15) << robot;
  }
}

MapResult map_of(RingDrive drive, const std::string& solver, std::map<std::string, double>& said) {
  IniFile ini("[solver]\n" + solver, "test.ini");
  Mapper mapper(read_motion_options(ini), {make_plugin("LaserScans", ini)},
                make_backend(ini.section("solver")), false);
  for (std::size_t i = 0; 2 * i < drive.way.size(); ++i) mapper.add(drive.keyframe(i));
  mapper.finish();
  said = mapper.statistics();
  EXPECT_TRUE(mapper.warnings().empty());
  return mapper.result();
}

// A bounded window keeps keyframes with scans, as full smoothing does: any of them may be one end
// of a later closure.
TEST(LaserScans, ABoundedWindowClosesLoopsToWhatIsOld) {
  const RingDrive drive(1, 3);
  std::map<std::string, double> full, bounded;
  const MapResult right = map_of(drive, "mode = incremental", full);
  const MapResult result = map_of(drive, "mode = bounded\ncomplete = 60\nsightings = 20", bounded);
  EXPECT_EQ(bounded.at("scan_closures_accepted"), full.at("scan_closures_accepted"));
  EXPECT_NEAR(errors_of(result, drive).map, errors_of(right, drive).map, 1e-6);
}

// In a window of the last keyframes there is no room for closures to older ones.
TEST(LaserScans, ClosuresThatAreNotInTheMapAreNotSaidToBe) {
  std::map<std::string, double> said;
  map_of(RingDrive(1), "mode = fixed_lag\nlag = 20", said);
  EXPECT_GT(said.at("scan_closures"), 20);
  EXPECT_LT(said.at("scan_closures_accepted"), 0.3 * said.at("scan_closures"));
}

TEST(LaserScans, KeyframesWithoutScansAreSkipped) {
  RingDrive drive(2);
  Mapper mapper = testing::make_mapper("LaserScans", false);
  for (std::size_t i = 0; i < 40; ++i) {
    Keyframe keyframe = drive.keyframe(i);
    if (i % 3 != 0) keyframe.scans.clear();
    mapper.add(keyframe);
  }
  mapper.finish();
  EXPECT_GT(mapper.measurements(), 10u);
  EXPECT_LT(errors_of(mapper, drive).map, 0.2);
}

}  // namespace
}  // namespace hybrid
