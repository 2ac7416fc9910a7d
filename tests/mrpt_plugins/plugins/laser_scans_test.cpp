// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "mrpt_plugins/plugins/laser_scans.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/mrpt_plugins/plugins/beacon_world.h"
#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

/// A drive of two rounds along the ring of corridors, a keyframe every half metre and a scan
/// between two of them, by noisy odometry.
class RingDrive {
 public:
  explicit RingDrive(unsigned seed) : random_(seed) {}

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
            way[k].between(way[k + 1]) *
            SE2(0.01 * noise_(random_), 0.005 * noise_(random_), 0.01 * noise_(random_));
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

 private:
  LaserScan scan(const SE2& pose, double time) {
    LaserScan scan = plan_.scan(pose, 181, 0.015, random_);
    scan.time = time;
    return scan;
  }

  testing::FloorPlan plan_ = testing::ring();
  std::mt19937 random_;
  std::normal_distribution<double> noise_;
};

struct Errors {
  double map = 0, odometry = 0;  // root mean square [m]
};

Errors errors_of(const Mapper& mapper, const RingDrive& drive) {
  const MapResult result = mapper.result();
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
