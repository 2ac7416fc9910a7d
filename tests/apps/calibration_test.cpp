// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <cmath>
#include <string>

#include "tests/apps/replay_runner.h"

namespace hybrid {
namespace {

class Calibration : public ReplayTest {
 protected:
  /// Simulates a world given by an INI and returns an INI that replays it with these sections.
  std::string simulated(const std::string& scenario, const std::string& sections) const {
    const std::string command = HYBRID_BINARY_DIR "/bin/hybrid-simulate -c " +
                                write("world.ini", scenario) + " -o " + at("log.rawlog") +
                                " > /dev/null";
    EXPECT_EQ(std::system(command.c_str()), 0);
    return write("replay.ini",
                 "[log]\nrawlog = log.rawlog\ntruth_path = log_ground_truth_robot_path.txt\n"
                 "truth_map = log_ground_truth.txt\n" +
                     sections);
  }
};

constexpr const char* kSensor = "pose of sensor without label";

TEST_F(Calibration, SensorPoseOfTheNoncenteredLog) {
  const auto summary = summary_of("-c " + config("kf_slam_6d_demo_noncentered_calibrate.ini"));
  const auto& found = summary["calibration"][kSensor];
  const auto error = [&](const char* name, double truth) {
    return std::abs(found[name]["value"].get<double>() - truth);
  };
  EXPECT_LT(std::hypot(error("x", 0.5), error("y", 0.2), error("z", 0.1)), 0.02);
  EXPECT_LT(error("yaw", 80), 0.2);
  EXPECT_LT(error("pitch", -20), 0.2);
  EXPECT_LT(error("roll", 10), 0.2);
  EXPECT_GT(std::abs(found["yaw"]["start"].get<double>() - 80), 15);
  EXPECT_LT(summary["truth"]["landmarks"]["mean_m"].get<double>(), 0.03);
}

/// Without being told that the robot drives steadily, the estimate keeps to its own covariance.
TEST_F(Calibration, CovarianceIsHonest) {
  std::string ini = read_file(config("kf_slam_6d_demo_noncentered_calibrate.ini"));
  ini.replace(ini.find("steady_sigma_m = 0.01"), 21, "");
  const auto summary = summary_of("-c " + write("a.ini", ini));
  const double truth[] = {0.5, 0.2, 0.1, 80, -20, 10};
  int i = 0;
  for (const char* name : {"x", "y", "z", "yaw", "pitch", "roll"}) {
    const auto& entry = summary["calibration"][kSensor][name];
    EXPECT_TRUE(entry["observed"].get<bool>());
    EXPECT_LT(std::abs(entry["value"].get<double>() - truth[i++]),
              3.5 * entry["sigma"].get<double>())
        << name;
  }
}

TEST_F(Calibration, OdometryAndSensorInThePlane) {
  const auto check = [&](const std::string& arguments) {
    const auto summary = summary_of(arguments);
    const auto near = [&](const char* what, const char* name, double truth) {
      const auto& entry = summary["calibration"][what][name];
      EXPECT_NEAR(entry["value"].get<double>(), truth, 3.5 * entry["sigma"].get<double>()) << name;
    };
    near("odometry", "scale of translation", 0.94);
    near("odometry", "scale of rotation", 1.08);
    near("odometry", "drift", 1.5);
    near("pose of sensor DETECTOR", "x", 0.4);
    near("pose of sensor DETECTOR", "y", -0.2);
    near("pose of sensor DETECTOR", "yaw", 25);
    EXPECT_LT(summary["truth"]["trajectory"]["rmse_m"].get<double>(), 0.1);
    EXPECT_GT(summary["truth"]["dead_reckoning"]["rmse_m"].get<double>(), 3.0);
  };
  check("-c " + config("calibration_demo.ini"));
  std::string ini = read_file(config("calibration_demo.ini"));
  const std::string to = std::string("= ") + HYBRID_SOURCE_DIR + "/rawlogs/";
  for (std::size_t p; (p = ini.find("= ../rawlogs/")) != std::string::npos;) ini.replace(p, 13, to);
  check("-c " + write("batch.ini", ini + "\n[solver]\nmode = batch\n"));
}

/// On a straight line a sensor may sit anywhere, as long as the map moves with it.
TEST_F(Calibration, WhatIsNotObservedIsNoNumber) {
  const std::string ini = simulated(
      "[simulation]\nobservation = plain\n[path]\nshape = waypoints\nwaypoints = 20 0\n"
      "[sensor]\npose = 0.3 0.1 0 10 0 0\n[world]\nmin_corner = 0 -6 0\n"
      "max_corner = 20 6 0\n",
      "[calibration]\nsensor_pose = yes\n");
  const auto summary = summary_of("-c " + ini);
  const auto& sensor = summary["calibration"]["pose of sensor DETECTOR"];
  for (const char* name : {"x", "y"}) {
    EXPECT_TRUE(sensor[name]["value"].is_null()) << name;
    EXPECT_FALSE(sensor[name]["observed"].get<bool>()) << name;
  }
  const Ran ran = run_replay("-c " + ini + " --no-pictures -o " + at("out"));
  EXPECT_NE(ran.text.find("x is not determined by the measurements of this log"), std::string::npos)
      << ran.text;
}

TEST_F(Calibration, BadInputIsNamed) {
  const std::string demo =
      "[log]\nrawlog = " HYBRID_SOURCE_DIR "/rawlogs/calibration_demo.rawlog\n[calibration]\n";
  const auto fails = [&](const std::string& keys, const std::string& part) {
    expect_failure("-c " + write("bad.ini", demo + keys), part);
  };
  fails("sensor_pose = yes\nsensor_start = 1 2 3\n", "sensor_start");
  fails("sensor_pose = yes\nsensor_start = 0 0 0 0 10 0\n", "has pitch or roll");
  fails("odometry = yes\nodometry_start = 1 1\n", "odometry_start has 2 numbers");
  fails("sensor_sigma_m = 0\n", "sensor_sigma_m");
}

}  // namespace
}  // namespace hybrid
