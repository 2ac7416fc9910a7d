// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/carmen.h"

#include <bzlib.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <cmath>

#include "mrpt_plugins/input/scans.h"
#include "tests/mrpt_plugins/import/import_files.h"

namespace hybrid {
namespace {

constexpr double kStepDegree = M_PI / 180;

/// A FLASER line of `rays` ranges, all of 2 m but the last at 81.91.
std::string front_laser(int rays, double x, double time) {
  std::string line = "FLASER " + std::to_string(rays);
  for (int i = 1; i < rays; ++i) line += " 2.00";
  const std::string pose = " " + std::to_string(x) + " 0 0";
  return line + " 81.91 9 9 9" + pose + " " + std::to_string(time) + " host 0.5\n";
}

std::string compressed(const std::string& text) {
  std::string out(text.size() + 1000, '\0');
  auto size = static_cast<unsigned>(out.size());
  EXPECT_EQ(BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(text.data()),
                                     static_cast<unsigned>(text.size()), 1, 0, 0),
            BZ_OK);
  out.resize(size);
  return out;
}

class Carmen : public ImportTest {
 protected:
  ImportReport import(const std::string& text, CarmenOptions options = {}) {
    write("log.clf", text);
    options.file = at("log.clf");
    return import_carmen(options, log());
  }

  /// The scan of step i as the mapping sees it.
  LaserScan scan_of(std::size_t i) const {
    DropReport report;
    return scan_in(*steps().at(i).observations.at(0), {}, report).value();
  }

  static bool notes_angle(const ImportReport& report) { return tells(report, "180 degrees taken"); }
};

/// Direction of a ray seen from the robot.
double direction(const LaserScan& scan, std::size_t i) {
  const double angle = scan.first_angle + static_cast<double>(i) * scan.angle_step;
  const Eigen::Vector3d ray =
      scan.T_robot_sensor.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
  return std::atan2(ray.y(), ray.x());
}

TEST_F(Carmen, FrontLaserWithItsOdometry) {
  const ImportReport report =
      import("# a comment\nPARAM robot_frontlaser_offset 0.25 x 1\n" + front_laser(180, 1, 10) +
             "ODOM 7 7 7\n" + front_laser(180, 1.5, 10.2) + "UNHEARD line\n");
  EXPECT_TRUE(notes_angle(report));
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_NEAR(all[1].time, 10.2, 1e-6);
  ASSERT_TRUE(all[1].odometry);
  EXPECT_NEAR(all[1].odometry->mean.x(), 0.5, 1e-9);
  EXPECT_NEAR(all[1].odometry->covariance(0, 0), 0.05 * 0.05 * 0.5 + 1e-6, 1e-9);
  const LaserScan scan = scan_of(0);
  ASSERT_EQ(scan.ranges.size(), 180U);
  EXPECT_EQ(scan.ranges[0], 2);
  EXPECT_TRUE(std::isnan(scan.ranges[179])) << "nothing seen up to the maximum range";
  EXPECT_NEAR(direction(scan, 0), -M_PI_2, 1e-6);
  EXPECT_NEAR(direction(scan, 179), 89 * kStepDegree, 1e-6);
  EXPECT_NEAR(scan.T_robot_sensor.translation().x(), 0.25, 1e-9);
}

TEST_F(Carmen, OdometryThatStartsAnewIsMissingThere) {
  std::string text;
  for (int i = 0; i < 20; ++i) text += front_laser(180, i % 10, i);
  const ImportReport report = import(text);
  EXPECT_EQ(
      report.dropped.at("odometry dropped: it starts anew, so that the motion there is not known"),
      1U);
  for (const LogStep& step : steps()) EXPECT_EQ(step.odometry.has_value(), step.index % 10 != 0);
}

TEST_F(Carmen, AnglesOfTheRays) {
  import(front_laser(361, 0, 1));
  EXPECT_NEAR(direction(scan_of(0), 0), -M_PI_2, 1e-6);
  EXPECT_NEAR(direction(scan_of(0), 360), M_PI_2, 1e-6);
  const std::string told = "PARAM laser_front_laser_resolution 0.5 x 1\n";
  EXPECT_FALSE(notes_angle(import(told + front_laser(180, 0, 1))));
  EXPECT_NEAR(direction(scan_of(0), 0), -45 * kStepDegree, 1e-6);
  EXPECT_NEAR(direction(scan_of(0), 179), 44.5 * kStepDegree, 1e-6);
  CarmenOptions options;
  options.fov_deg = 360;
  EXPECT_FALSE(notes_angle(import(told + front_laser(180, 0, 1), options)));
  EXPECT_NEAR(direction(scan_of(0), 91), 2 * kStepDegree, 1e-6);
  import(front_laser(1, 0, 1));
  EXPECT_TRUE(std::isnan(scan_of(0).ranges.at(0)));
}

TEST_F(Carmen, LasersThatDescribeThemselves) {
  // Three rays from -45 to 45 degrees, seen from 0.5 m ahead of the robot; one remission.
  const std::string described = " 0 -0.785398 1.570796 0.785398 5 0.01 0 3 1 2 5 1 77";
  const std::string behind = " 10.5 20 0 10 20 0 0 0 0 0 0 3 host 0\n";
  import("ROBOTLASER1" + described + behind + "RAWLASER1" + described + " 4 host 0\n" +
         "ODOM 11 20 0 0 0 0 5 host 0\nRAWLASER1" + described + " 6 host 0\n");
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U) << "the second one has no odometry before it";
  EXPECT_NEAR(all[0].time, 3, 1e-6);
  EXPECT_NEAR(all[1].time, 6, 1e-6);
  EXPECT_NEAR(all[1].odometry->mean.x(), 1, 1e-9);
  const LaserScan scan = scan_of(0);
  EXPECT_NEAR(scan.T_robot_sensor.translation().x(), 0.5, 1e-9);
  EXPECT_NEAR(direction(scan, 0), -45 * kStepDegree, 1e-5);
  EXPECT_EQ(scan.ranges[1], 2);
  EXPECT_TRUE(std::isnan(scan.ranges[2]));
}

TEST_F(Carmen, CompressedLogsAreTheSame) {
  const std::string first = front_laser(180, 1, 1), second = front_laser(180, 2, 2);
  import(compressed(first + second));
  EXPECT_EQ(steps().size(), 2U);
  import(compressed(first) + compressed(second));
  EXPECT_EQ(steps().size(), 2U) << "of two streams";
  std::string damaged = compressed(first + second);
  damaged[damaged.size() / 2] ^= 0x10;
  std::filesystem::remove(log());
  expect_error([&] { import(damaged); }, "log.clf: the bzip2 data is damaged or ends early");
  const std::string whole = compressed(first + second);
  expect_error([&] { import(whole.substr(0, whole.size() - 9)); }, "ends early");
}

TEST_F(Carmen, WhatCannotBeReadIsSaid) {
  expect_error([&] { import("ODOM 1 2 3\n"); }, "no line FLASER");
  expect_error([&] { import("FLASER 3 1 2 x 0 0 0 0 0 0 1 h 0\n"); }, "log.clf:1:14: ");
  expect_error([&] { import("FLASER 300 1 2 0 0 0 0 0 0 1 h 0\n"); }, "the line ends early");
  expect_error([&] { import("FLASER -1\n"); }, "log.clf:1:8: ");
  expect_error([&] { import("FLASER\n"); }, "the number of ranges is missing");
  const ImportReport report =
      import(front_laser(3, 0, 5) + front_laser(3, 0, 5) + front_laser(3, 0, 4) +
             "FLASER 0 0 0 0 0 0 0 9 h 0\n" + "RLASER 1 1\n");
  EXPECT_EQ(report.steps, 3U);
  EXPECT_EQ(report.dropped.at("time stamp repaired: it went backwards, that of the scan before "
                              "taken"),
            1U);
  EXPECT_EQ(steps().at(2).time, 5);
  EXPECT_EQ(report.dropped.at("scan dropped: no rays"), 1U);
}

TEST_F(Carmen, ALogThatIsCutOffIsToldOf) {
  const std::string text = front_laser(180, 1, 1) + front_laser(180, 2, 2) + "ODOM 2 0 0 0.5 0 0 2";
  EXPECT_TRUE(tells(import(text), "cut off?"));
  EXPECT_FALSE(tells(import(text + " host 2\n"), "cut off?"));
  EXPECT_FALSE(tells(import(compressed(text + " host 2\n")), "cut off?"));
}

TEST_F(Carmen, ALastLineThatIsCutOffIsLeftOut) {
  const std::string whole = front_laser(180, 1, 1) + front_laser(180, 2, 2);
  const std::string cut = whole + front_laser(180, 3, 3).substr(0, 300);
  const ImportReport report = import(cut);
  EXPECT_EQ(report.steps, 2U);
  EXPECT_TRUE(tells(report, "its last line, 3, is cut off: what comes before it is used"));
  EXPECT_FALSE(tells(report, "cut off?"));
  EXPECT_EQ(import(compressed(cut)).steps, 2U);
  std::filesystem::remove(log());
  expect_error([&] { import(cut + "\n"); }, "log.clf:3:");
  expect_error([&] { import(cut + "\n" + whole); }, "log.clf:3:");
  expect_error([&] { import(front_laser(180, 3, 3).substr(0, 300)); }, "log.clf:1:");
}

/// A FLASER line whose laser is at `ahead` m of the robot, which looks along y.
std::string laser_ahead(double y, double ahead, double time) {
  return "FLASER 3 2 2 2 0 " + std::to_string(y + ahead) + " 1.570796 0 " + std::to_string(y) +
         " 1.570796 " + std::to_string(time) + " host 0\n";
}

TEST_F(Carmen, TheFirstPoseOfALineIsThatOfTheLaser) {
  const std::string param = "PARAM robot_frontlaser_offset 0.3 x 1\n";
  const ImportReport report = import(laser_ahead(0, 0.3, 1) + laser_ahead(2, 0.3, 2));
  EXPECT_NEAR(scan_of(0).T_robot_sensor.translation().x(), 0.3, 1e-5);
  EXPECT_NEAR(scan_of(0).T_robot_sensor.translation().y(), 0, 1e-5);
  EXPECT_NEAR(steps().at(1).odometry->mean.x(), 2, 1e-5);
  EXPECT_TRUE(tells(report, "x 0.300 m"));
  EXPECT_FALSE(tells(import(param + laser_ahead(0, 0.31, 1) + laser_ahead(2, 0.3, 2)), "x 0.3"));
  EXPECT_EQ(scan_of(0).T_robot_sensor.translation().x(), 0.3) << "what is stated is not rounded";
  import(laser_ahead(0, 0, 1) + laser_ahead(2, 0.3, 2));  // as of poses that were corrected
  EXPECT_EQ(scan_of(0).T_robot_sensor.translation().x(), 0);
}

TEST_F(Carmen, ALaserOfACorrectedPathIsWhereParameterLinesSay) {
  const auto line = [](double laser, double robot) {
    return "ROBOTLASER1 0 -0.785398 1.570796 0.785398 5 0.01 0 3 1 2 3 0 " + std::to_string(laser) +
           " 0 0 " + std::to_string(robot) + " 0 0 0 0 0 0 0 " + std::to_string(robot + 1) +
           " host 0\n";
  };
  const auto ahead = [&](std::size_t i) { return scan_of(i).T_robot_sensor.translation().x(); };
  EXPECT_FALSE(tells(import(line(0.3, 0) + line(2.3, 2)), "not fixed"));
  EXPECT_NEAR(ahead(1), 0.3, 1e-6);
  EXPECT_TRUE(tells(import(line(0.3, 0) + line(2.5, 2)), "not fixed"));
  EXPECT_EQ(ahead(0), 0);
  EXPECT_EQ(ahead(1), 0);
  import("PARAM robot_frontlaser_offset 0.25 x 1\n" + line(0.3, 0) + line(2.5, 2));
  EXPECT_EQ(ahead(1), 0.25);
}

TEST_F(Carmen, TheFieldOfViewOfParameterLines) {
  const std::string fov = "PARAM laser_front_laser_fov 4.71239\n";
  const auto first = [&] { return direction(scan_of(0), 0) / kStepDegree; };
  import(fov + front_laser(271, 0, 1));
  EXPECT_NEAR(first(), -135, 0.01);
  EXPECT_TRUE(
      tells(import("PARAM laser_front_laser_resolution 0.5\n" + fov + front_laser(271, 0, 1)),
            "271 rays 0.5 degrees apart cover 135 degrees, and the field of view is 270; the "
            "latter is taken"));
  EXPECT_NEAR(first(), -135, 0.01);
  EXPECT_TRUE(tells(import("PARAM laser_front_laser_resolution 0.5\n"
                           "PARAM laser_front_laser_fov 180\n" +
                           front_laser(541, 0, 1)),
                    "the former is taken"));
  EXPECT_NEAR(first(), -135, 0.01);
  EXPECT_FALSE(tells(import("PARAM laser_front_laser_resolution 1.0\n"
                            "PARAM laser_front_laser_fov 180\n" +
                            front_laser(180, 0, 1)),
                     "contradict"));
  EXPECT_NEAR(first(), -90, 0.01);
}

TEST_F(Carmen, WhatReachesWithoutALimit) {
  for (const char* most : {"inf", "3.4028235e+38", "0", "nan"}) {
    import("ROBOTLASER1 0 -0.785398 1.570796 0.785398 " + std::string(most) +
           " 0.01 0 3 1 inf 500 0 10.5 20 0 10 20 0 0 0 0 0 0 3 host 0\n");
    const LaserScan scan = scan_of(0);
    EXPECT_EQ(scan.ranges[0], 1) << most;
    EXPECT_TRUE(std::isnan(scan.ranges[1])) << most;
    EXPECT_EQ(scan.ranges[2], 500) << most;
  }
}

std::string odometry(double x, const std::string& time) {
  return "ODOM " + std::to_string(x) + " 0 0 0 0 0 " + time + " host 0\n";
}
std::string raw_laser(const std::string& time) {
  return "RAWLASER1 0 -0.785398 1.570796 0.785398 5 0.01 0 3 1 2 3 0 " + time + " host 0\n";
}

TEST_F(Carmen, OdometryIsThatOfTheTimeOfTheScan) {
  const auto way = [&](std::size_t i) { return steps().at(i).odometry->mean.x(); };
  import(odometry(0, "1") + raw_laser("1") + raw_laser("2") + raw_laser("3") + odometry(6, "4") +
         raw_laser("4") + raw_laser("4.5"));
  ASSERT_EQ(steps().size(), 5U);
  EXPECT_NEAR(way(1), 2, 1e-9);
  EXPECT_NEAR(way(2), 2, 1e-9);
  EXPECT_NEAR(way(3), 2, 1e-9);
  EXPECT_NEAR(way(4), 0, 1e-9) << "the last line counts at the end";
  import(raw_laser("1") + odometry(0, "1") + raw_laser("2") + odometry(2, "2"));
  ASSERT_EQ(steps().size(), 2U) << "a line just behind its scan";
  EXPECT_NEAR(way(1), 2, 1e-9);
  import(odometry(0, "1") + odometry(2, "2") + raw_laser("1.5") + odometry(4, "3") +
         raw_laser("2.5"));
  EXPECT_NEAR(way(1), 2, 1e-9) << "a scan that is written late";
}

TEST_F(Carmen, OdometryOfAnotherClockIsThatOfTheLineBefore) {
  for (const char* second : {"50", "0.5"}) {
    import(odometry(0, second) + raw_laser("1") + odometry(2, second[0] == '5' ? "51" : "0.4") +
           raw_laser("2") + odometry(4, "52"));
    ASSERT_EQ(steps().size(), 2U);
    EXPECT_NEAR(steps().at(1).odometry->mean.x(), 2, 1e-9);
  }
}

TEST_F(Carmen, WhereOdometryStartsAnewItIsNotInterpolated) {
  std::string text;
  for (int i = 0; i < 20; ++i) {
    const std::string time = std::to_string(i);
    text += odometry(i % 10, time) + raw_laser(time) + raw_laser(time + ".5");
  }
  import(text);
  for (const LogStep& step : steps()) {
    if (step.odometry) {
      EXPECT_LT(std::abs(step.odometry->mean.x()), 1.1);
    }
  }
}

TEST_F(Carmen, ALaserThatParameterLinesTurn) {
  import(
      "PARAM robot_frontlaser_offset 0.3 x 1\nPARAM robot_frontlaser_side_offset 0.2 x 1\n"
      "PARAM robot_frontlaser_angular_offset 1.570796 x 1\n" +
      odometry(0, "1") + raw_laser("1"));
  const LaserScan scan = scan_of(0);
  EXPECT_NEAR(scan.T_robot_sensor.translation().x(), 0.3, 1e-9);
  EXPECT_NEAR(scan.T_robot_sensor.translation().y(), 0.2, 1e-9);
  EXPECT_NEAR(direction(scan, 1), 90 * kStepDegree, 1e-5);
}

TEST_F(Carmen, ScansWithoutAnyOdometry) {
  const std::string scan = "RAWLASER1 0 -0.785398 1.570796 0.785398 5 0.01 0 3 1 2 5 0 ";
  EXPECT_EQ(import(scan + "4 host 0\n" + scan + "5 host 0\n").steps, 2U);
  EXPECT_FALSE(steps().at(1).odometry);
}

}  // namespace
}  // namespace hybrid
