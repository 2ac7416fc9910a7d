// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <cmath>
#include <sstream>
#include <utility>

#include "tests/apps/replay_runner.h"
#include "tests/support/data_path.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

class ImportAppTest : public ReplayTest {
 protected:
  Ran run_import(const std::string& arguments) const {
    return run_app("hybrid-import " + arguments + " -o " + at("in.rawlog"));
  }
  /// A public data set, or empty where it is absent.
  static std::string data(const std::string& name) {
    const std::string path = testing::data_path(name);
    return fs::exists(path) ? path : "";
  }
  /// Imports, replays with a configuration of the repository, and returns the summary.
  nlohmann::json imported(const std::string& arguments, const std::string& ini,
                          const std::string& path_suffix, bool map) const {
    const Ran ran = run_import(arguments);
    EXPECT_EQ(ran.code, 0) << ran.text;
    return summary_of("-c " + config(ini) + " --rawlog " + at("in.rawlog") + " --truth-path " +
                      at("in_ground_truth_robot_path" + path_suffix) +
                      (map ? " --truth-map " + at("in_ground_truth.txt") : ""));
  }
};

TEST_F(ImportAppTest, ConvertsTablesThatReplayMaps) {
  write("odometry.csv", "time,x,y,yaw\n0,0,0,0\n1,1,0,0\n2,2,0,0\n3,3,0,0\n");
  write("detections.csv",
        "time,range,yaw,class,score,id\n0,5,0,tree,0.9,1\n1,4,0,tree,0.9,1\n"
        "2,3,0,tree,0.9,1\n2,3,1.5,car,0.8,2\n3,0,0,tree,0.9,1\n");
  const Ran ran =
      run_import("csv --odometry " + at("odometry.csv") + " --detections " + at("detections.csv"));
  ASSERT_EQ(ran.code, 0) << ran.text;
  EXPECT_NE(ran.text.find("detection dropped: range not positive: 1"), std::string::npos);
  const auto summary = summary_of("-c " + config("csv_demo.ini") + " --rawlog " + at("in.rawlog"));
  EXPECT_EQ(summary["landmarks"], 2);
}

/// A robot that moves by so much in each of 0.2 s, or not, and sees things; all without noise but
/// for a little of the range.
struct PoorLog {
  int frames = 60;
  double ahead = 0.1, turn = 0.02;
  int side = 4;            ///< things in a square of side x side
  double spacing = 2;      ///< m
  std::string sigma = "";  ///< of ranges and yaws that the table states
};

std::pair<std::string, std::string> tables_of(const PoorLog& log) {
  std::ostringstream odometry, detections;
  odometry << "time,x,y,yaw\n";
  detections << "time,range,yaw" << (log.sigma.empty() ? "" : ",sigma_range,sigma_yaw") << "\n";
  double x = 0, y = 0, yaw = 0;
  for (int i = 0; i <= log.frames; ++i) {
    odometry << 0.2 * i << ',' << x << ',' << y << ',' << yaw << '\n';
    for (int k = 0; k < log.side * log.side && i < log.frames; ++k) {
      const double dx = 3 + log.spacing * (k % log.side) - x;
      const double dy = 0.5 * log.spacing * (1 - log.side) + log.spacing * (k / log.side) - y;
      const double range = std::hypot(dx, dy) + 0.03 * std::sin(7.0 * k + 3.0 * i);
      const double seen = std::remainder(std::atan2(dy, dx) - yaw, 2 * M_PI);
      if (range > 10 || std::abs(seen) > 1.5) continue;
      detections << 0.2 * i << ',' << range << ',' << seen;
      if (!log.sigma.empty()) detections << ',' << log.sigma << ',' << log.sigma;
      detections << '\n';
    }
    x += log.ahead * std::cos(yaw);
    y += log.ahead * std::sin(yaw);
    yaw += log.turn;
  }
  return {odometry.str(), detections.str()};
}

TEST_F(ImportAppTest, LogsThatTellNextToNothingAreMeasuredAsFarAsTheyTell) {
  const auto mapped = [&](const PoorLog& log, const std::string& expected) {
    const auto [odometry, detections] = tables_of(log);
    write("odometry.csv", odometry);
    write("detections.csv", detections);
    const Ran ran = run_import("csv --odometry " + at("odometry.csv") + " --detections " +
                               at("detections.csv"));
    EXPECT_EQ(ran.code, 0) << ran.text;
    EXPECT_NE(ran.text.find(expected), std::string::npos) << ran.text;
    const std::string replay =
        "hybrid-replay " + at("in.rawlog") + " --no-pictures -o " + at("out");
    for (const char* noise : {"auto", "measured"}) {
      const Ran made = run_app(replay + " --set sensor.noise=" + noise);
      EXPECT_EQ(made.code & ~2, 0) << made.text;  // ok or empty
    }
    return nlohmann::json::parse(read("out/summary.json"));
  };
  PoorLog log;
  log.frames = 1;
  EXPECT_EQ(mapped(log, "not measured, too few frames with detections").at("status"), "empty");
  log = {};
  log.ahead = log.turn = 0;
  EXPECT_NE(mapped(log, "noise of range").at("alignment")[0].value("unknown", ""), "");
  log = {};
  log.turn = 0;
  EXPECT_NE(mapped(log, "noise of range").at("alignment")[0].value("unknown", ""), "");
  log = {};
  log.side = 1;
  EXPECT_EQ(mapped(log, "noise").at("landmarks"), 1);
  log = {};
  log.sigma = "0";
  EXPECT_EQ(mapped(log, "noise of range").at("landmarks"), 16);
  log = {};
  log.frames = 12;
  log.side = 32;
  log.spacing = 1.0 / 32;
  const nlohmann::json dense = mapped(log, "noise: not measured");
  EXPECT_GT(dense.at("dropped").value(
                "detection dropped: too many others within its noise to be told apart", 0),
            10000);
}

TEST_F(ImportAppTest, ExplainsItselfAndFailsClearly) {
  for (const char* arguments : {"--help", "victoria-park --help", "kitti --help", "csv --help"}) {
    const Ran ran = run_app(std::string("hybrid-import ") + arguments);
    EXPECT_EQ(ran.code, 0) << ran.text;
    EXPECT_GT(ran.text.size(), 300U);
  }
  EXPECT_NE(run_app("hybrid-import").code, 0);
  EXPECT_NE(run_app("hybrid-import nothing -o x.rawlog").code, 0);
  const Ran ran = run_import("victoria-park " + at("nowhere"));
  EXPECT_EQ(ran.code, 1);
  EXPECT_NE(ran.text.find("no such file"), std::string::npos) << ran.text;
  EXPECT_FALSE(fs::exists(at("in.rawlog")));
  EXPECT_NE(run_app("hybrid-import victoria-park x -o " + at("log.txt")).text.find(".rawlog"),
            std::string::npos);
}

TEST_F(ImportAppTest, MrclamWithBarcodes) {
  const std::string folder = data("mrclam/MRCLAM_Dataset6");
  if (folder.empty()) GTEST_SKIP() << "MR.CLAM set 6 is absent";
  const auto truth =
      imported("mrclam " + folder + " --robot 4", "mrclam_6.ini", ".txt", true)["truth"];
  EXPECT_LT(truth["trajectory"]["aligned"]["rmse_m"], 0.25);
  EXPECT_EQ(truth["landmarks"]["matched"], 15);
}

TEST_F(ImportAppTest, KittiWithTrueAssociation) {
  const std::string viso = data("kitti_viso2_robustslam/07/kitti_07_odom.g2o");
  const std::string boxes = data("kitti_yolov3/07_yolov3.txt"),
                    poses = data("kitti_gt_poses/07.txt");
  if (viso.empty() || boxes.empty() || poses.empty()) GTEST_SKIP() << "KITTI 07 is absent";
  const auto truth = imported(
      "kitti --focal 707.0912 --center-u 601.8873 --center-v 183.1104 --oracle-radius 2 "
      "--odometry " +
          viso + " --boxes " + boxes + " --truth " + poses,
      "kitti_07.ini", ".txt", false)["truth"];
  EXPECT_NEAR(truth["dead_reckoning"]["aligned"]["mean_m"], 2.48, 0.05);
  EXPECT_LT(truth["trajectory"]["aligned"]["mean_m"], 0.9);
  EXPECT_LT(truth["nees_pose"], 1.5);
}

TEST_F(ImportAppTest, Plaza) {
  const std::string graph = data("plaza_ada/Plaza1_EFG.fg");
  if (graph.empty()) GTEST_SKIP() << "Plaza 1 is absent";
  ASSERT_EQ(run_import("plaza " + graph).code, 0);
  const auto known =
      summary_of("-c " + config("plaza1.ini") + " --rawlog " + at("in.rawlog") + " --truth-path " +
                 at("in_ground_truth_robot_path.txt") + " --truth-map " +
                 at("in_ground_truth.txt") + " --set log.truth_associations=")["truth"];
  const double all = known["trajectory"]["aligned"]["rmse_m"];
  EXPECT_LT(all, 1.0);
  ASSERT_EQ(
      run_import("plaza " + data("plaza_ada/Plaza1_ADA0.6EFG.fg") + " --identities " + graph).code,
      0);
  const auto hidden = summary_of(
      "-c " + config("plaza1.ini") + " --rawlog " + at("in.rawlog") + " --truth-path " +
      at("in_ground_truth_robot_path.txt") + " --truth-map " + at("in_ground_truth.txt") +
      " --set log.truth_associations=" + at("in_ground_truth_associations.csv"))["truth"];
  EXPECT_EQ(hidden["associations"]["labelled"], 447);
  EXPECT_GT(hidden["association_accuracy"], 0.93);
  EXPECT_EQ(hidden["landmarks"]["matched"], 4);
  EXPECT_LT(double(hidden["trajectory"]["aligned"]["rmse_m"]), 1.15 * all);
}

TEST_F(ImportAppTest, MrptsRangeOnlyDemonstration) {
  if (!fs::exists("/usr/share/mrpt/datasets/RO-SLAM_demo.rawlog")) GTEST_SKIP() << "no MRPT logs";
  const auto summary = summary_of("-c " + config("ro_slam_demo.ini"));
  EXPECT_EQ(summary["truth"]["landmarks"]["matched"], 15);
  EXPECT_LT(summary["truth"]["landmarks"]["mean_m"], 0.2);
}

}  // namespace
}  // namespace hybrid
