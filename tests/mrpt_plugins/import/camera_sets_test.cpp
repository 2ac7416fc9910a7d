// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <cmath>

#include "mrpt_plugins/evaluation/ground_truth.h"
#include "mrpt_plugins/evaluation/mover_truth.h"
#include "mrpt_plugins/import/kitti.h"
#include "mrpt_plugins/import/kitti_tracking.h"
#include "mrpt_plugins/import/stata.h"
#include "tests/mrpt_plugins/import/import_files.h"

namespace hybrid {
namespace {

class CameraSets : public ImportTest {
 protected:
  /// Cameras that move forward, along z, by 1 m each.
  std::string poses(int count) const {
    std::string text;
    for (int i = 0; i < count; ++i) text += "1 0 0 0 0 1 0 0 0 0 1 " + std::to_string(i) + "\n";
    return write("poses.txt", text);
  }

  /// A box of a car 1.5 m high that stands on the road 10 m ahead of a camera at 1.65 m, its middle
  /// `right` metres to the right; and the pixels of it that a detector gives.
  static std::string box(int frame, const KittiOptions& o, double right) {
    const double bottom = o.center_v + o.focal * 1.65 / 10, height = o.focal * 1.5 / 10;
    const double u = o.center_u + o.focal * right / 10;
    return std::to_string(frame) + " " + std::to_string(u - 50) + " " +
           std::to_string(bottom - height) + " 100 " + std::to_string(height) + " 2 0.9\n";
  }

  KittiOptions kitti() const {
    KittiOptions options;
    options.odometry = write(
        "odometry.g2o", "EDGE_SE2 0 1 1 0 0 100 0 0 200 0 400\nEDGE_SE2 2 0 0 0 0 1 0 0 1 0 1\n");
    options.boxes = write("boxes.txt", box(0, options, 0) + box(1, options, 2) +
                                           "1 10 330 50 20 2 0.9\n1 10 10 50 50 2 0.8\n"
                                           "1 600 180 10 20 2 0.8\n1 10 10 50 50 0 0.8\n");
    options.truth = poses(2);
    return options;
  }
};

TEST_F(CameraSets, KittiBoxesBecomeRangesWithHonestNoise) {
  const KittiOptions options = kitti();
  const ImportReport report = import_kitti(options, log());
  expect_progress(2, 37.0 / 68.0);  // the motion is the first of two rows
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_NEAR(all[1].odometry->covariance(0, 0), 0.01, 1e-6);
  EXPECT_NEAR(all[1].odometry->covariance(5, 5), 0.0025, 1e-6);
  const auto& ahead = seen(all[0]).detections.at(0);
  EXPECT_NEAR(ahead.range, 12, 0.1);  // 10 m to its back, 2 m to its middle
  EXPECT_NEAR(ahead.yaw, 0, 1e-6);
  EXPECT_GT(ahead.std_range, 0.4);  // the scatter of real ones at 12 m is 0.43 m
  EXPECT_LT(ahead.std_range, 0.6);
  EXPECT_NEAR(ahead.class_scores.at(0), 0.9, 1e-6);
  ASSERT_EQ(seen(all[1]).detections.size(), 1U);
  EXPECT_LT(seen(all[1]).detections[0].yaw, -0.15);  // to the right is negative
  EXPECT_FALSE(seen(all[0]).has_pitch);
  EXPECT_EQ(report.dropped.at("box dropped: depth by height and depth by road differ"), 1U);
  EXPECT_EQ(report.dropped.at("box dropped: its lower edge is above the horizon"), 1U);
  EXPECT_EQ(report.dropped.at("box dropped: too far away"), 1U);
  EXPECT_EQ(report.dropped.at("box dropped: no vehicle"), 1U);
  EXPECT_EQ(report.dropped.at("loop closure dropped: only odometry is taken over"), 1U);
  EXPECT_NEAR(read_true_path(at("out_ground_truth_robot_path.txt")).at(1).x(), 1, 1e-9);
}

TEST_F(CameraSets, KittiFilesThatEndAtDifferentImagesAreErrors) {
  KittiOptions options = kitti();
  const auto import = [&] { import_kitti(options, log()); };
  options.truth = poses(1);
  expect_error(import, "poses.txt: ends with pose 1");
  options.truth = poses(3);
  expect_error(import, "poses.txt:3:1: more than 2 true poses");
  options.truth = poses(2);
  options.boxes = write("boxes.txt", box(0, options, 0) + box(2, options, 0));
  expect_error(import, "boxes.txt:2:1: image 2, after the end");
  options.oracle_radius = 2;
  options.truth.clear();
  expect_error(import, "an oracle radius needs true poses");
}

TEST_F(CameraSets, KittiOdometryWithYToTheRightIsTurned) {
  KittiOptions options = kitti();
  const auto lateral = [&](const char* y) {
    options.odometry =
        write("odometry.g2o", std::string("EDGE_SE2 0 1 1 ") + y + " 0.2 100 50 0 200 0 400\n");
    const ImportReport report = import_kitti(options, log());
    const auto repaired =
        report.dropped.find("motion repaired: the y of the odometry pointed to the right");
    return std::pair(steps().at(1).odometry.value(), repaired != report.dropped.end());
  };
  const auto [left, left_repaired] = lateral("0.1");
  const auto [right, right_repaired] = lateral("-0.1");
  EXPECT_FALSE(left_repaired);
  EXPECT_TRUE(right_repaired);
  EXPECT_NEAR(right.mean.y(), 0.1, 1e-9);
  EXPECT_NEAR(right.mean.yaw(), 0.2, 1e-9);
  EXPECT_NEAR(right.covariance(0, 1), -left.covariance(0, 1), 1e-9);
  EXPECT_NEAR(right.covariance(1, 1), left.covariance(1, 1), 1e-9);
}

TEST_F(CameraSets, KittiInSpaceMeasuresPitchAndTurnsCovariances) {
  KittiOptions options = kitti();
  options.odometry = poses(2);
  std::string covariance;  // camera z (forward) has a variance of 4, all else of 1
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) covariance += i != j ? "0 " : i == 2 ? "4 " : "1 ";
  }
  options.covariances = write("covariances.txt", covariance + "\n");
  options.inflate = 1;
  import_kitti(options, log());
  const auto all = steps();
  ASSERT_TRUE(all.at(1).odometry);
  EXPECT_NEAR(all[1].odometry->mean.x(), 1, 1e-9);
  EXPECT_NEAR(all[1].odometry->covariance(0, 0), 4, 1e-9);
  EXPECT_NEAR(all[1].odometry->covariance(1, 1), 1, 1e-9);
  EXPECT_TRUE(seen(all[0]).has_pitch);
  EXPECT_GT(seen(all[0]).detections.at(0).pitch, 0.05);  // below the camera: positive is down
}

TEST_F(CameraSets, KittiOracleNumbersWhatTheTruthPutsInOnePlace) {
  KittiOptions options = kitti();
  std::string edges, boxes;
  for (int i = 0; i < 5; ++i) {
    edges += "EDGE_SE2 " + std::to_string(i) + " " + std::to_string(i + 1) +
             " 0 0 0 100 0 0 200 0 400\n";
    boxes += box(i, options, 0) + box(i, options, i < 2 ? 4 : -4);
  }
  options.odometry = write("odometry.g2o", edges);
  options.boxes = write("boxes.txt", boxes);
  std::string truth;
  for (int i = 0; i < 6; ++i) truth += "1 0 0 0 0 1 0 0 0 0 1 0\n";
  options.truth = write("truth.txt", truth);
  options.oracle_radius = 2;
  import_kitti(options, log());
  const auto all = steps();
  const auto& d = seen(all.at(0)).detections;
  EXPECT_GE(d.at(0).true_landmark_id, 0);
  EXPECT_EQ(d.at(0).true_landmark_id, seen(all[4]).detections.at(0).true_landmark_id);
  EXPECT_EQ(d.at(0).landmark_id, mrpt::obs::INVALID_LANDMARK_ID);
  EXPECT_EQ(d.at(1).true_landmark_id, mrpt::obs::INVALID_LANDMARK_ID);  // seen there too seldom
}

TEST_F(CameraSets, KittiTrackingKnowsAllClassesOfItsLabels) {
  std::string labels;
  int track = 0;
  for (const char* type : {"Car", "Van", "Truck", "Pedestrian", "Cyclist", "Tram", "Misc",
                           "Person_sitting", "Person", "DontCare"}) {
    labels +=
        "0 " + std::to_string(track++) + " " + type + " 0 0 0 1 1 2 2 1.5 1.6 4 -1 1.6 20 0\n";
  }
  KittiTrackingOptions options;
  options.labels = write("labels.txt", labels);
  options.poses = poses(1);
  options.class_accuracy = 1;
  import_kitti_tracking(options, log());
  const auto all = steps();
  const auto& detections = seen(all.at(0)).detections;
  ASSERT_EQ(detections.size(), 9U);
  EXPECT_EQ(detections[8].class_scores, detections[7].class_scores) << "one class of two names";
}

TEST_F(CameraSets, KittiTrackingKeepsIdsOfWhatStands) {
  std::string labels;
  for (int i = 0; i < 4; ++i) {
    const auto row = [&](int track, const char* type, double z) {
      return std::to_string(i) + " " + std::to_string(track) + " " + type +
             " 0 0 0 1 1 2 2 1.5 1.6 4 -1 1.6 " + std::to_string(z) + " 0\n";
    };
    labels +=
        row(3, "Car", 20 - i) + row(4, "Van", 20 + i) + row(5, "Car", -3) + row(-1, "DontCare", 5);
  }
  KittiTrackingOptions options;
  options.labels = write("labels.txt", labels);
  options.poses = poses(4);
  options.noise = {0, 0, 1};
  const ImportReport report = import_kitti_tracking(options, log());
  expect_progress(4);
  const auto all = steps();
  ASSERT_EQ(all.size(), 4U);
  ASSERT_EQ(seen(all[2]).detections.size(), 2U);
  const auto& standing = seen(all[2]).detections[0];
  EXPECT_EQ(standing.landmark_id, 3);
  EXPECT_NEAR(standing.range, std::hypot(18, 1), 1e-6);
  EXPECT_GT(standing.yaw, 0);  // to the left
  EXPECT_NEAR(standing.std_yaw, std::hypot(0.004, 0.06 / standing.range), 1e-6);
  EXPECT_EQ(seen(all[2]).detections[1].landmark_id, mrpt::obs::INVALID_LANDMARK_ID);
  EXPECT_EQ(seen(all[2]).detections[1].true_landmark_id, 4);
  EXPECT_GT(seen(all[2]).detections[1].class_scores.at(1), 0.8);
  const TrueMovers movers = read_true_movers(at("out_ground_truth_movers.csv"));
  ASSERT_EQ(movers.size(), 1U);
  ASSERT_EQ(movers.at(4).size(), 4U);
  EXPECT_NEAR(movers.at(4).at(3).x(), 3 + 23, 1e-6);  // the robot drives as fast
  EXPECT_EQ(report.dropped.at("label dropped: behind the camera"), 4U);
  EXPECT_EQ(report.dropped.at("label dropped: DontCare"), 4U);
  const auto map = read_true_landmarks(at("out_ground_truth.txt"));
  ASSERT_EQ(map.size(), 1U);
  EXPECT_EQ(map[0].class_name, "Car");
  EXPECT_NEAR(map[0].position.x(), 20, 1e-6);

  // Poses 4 % too long: the scale is found, unless one is given.
  std::string longer;
  for (int i = 0; i < 4; ++i) {
    longer += "1 0 0 0 0 1 0 0 0 0 1 " + std::to_string(1.04 * i) + "\n";
  }
  options.poses = write("poses.txt", longer);
  EXPECT_NE(import_kitti_tracking(options, log()).notes.at(0).find("0.9615"), std::string::npos);
  EXPECT_NEAR(read_true_landmarks(at("out_ground_truth.txt")).at(0).position.x(), 20, 1e-6);
  EXPECT_NEAR(read_true_path(at("out_ground_truth_robot_path.txt")).at(3).x(), 3, 1e-6);
  options.pose_scale = 1;
  EXPECT_TRUE(import_kitti_tracking(options, log()).notes.empty());
  EXPECT_NEAR(read_true_path(at("out_ground_truth_robot_path.txt")).at(3).x(), 3.12, 1e-6);

  write("labels.txt", "0 1 Bicycle 0 0 0 1 1 2 2 1 1 1 0 0 9 0\n");
  EXPECT_THROW(import_kitti_tracking(options, log()), Error);
}

TEST_F(CameraSets, StataTurnsTheCameraAndDrawsTheSameNoise) {
  write("frames.txt", "0 0 1 0 0 0 0 1 0 0 0 0 1 0\n1 4 1 0 0 0 0 1 0 0 0 0 1 0.5\n");
  write("detections.txt",
        "0 14 0.8 0 0.5 2 0.1 1 2 3 4\n0 17 0.6 1 0 1 0.5 1 2 3 4\n1 9 0.5 0 0 -1 0.5 1 2 3 4\n");
  StataOptions options;
  options.folder = folder.string();
  const ImportReport report = import_stata(options, log());
  expect_progress(2);
  auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  const auto& cup = seen(all[0]).detections.at(0);
  EXPECT_NEAR(cup.range, std::hypot(2, 0.5), 1e-6);
  EXPECT_NEAR(cup.pitch, std::atan2(0.5, 2), 1e-6);
  EXPECT_NEAR(cup.class_scores.at(4), 0.8, 1e-6);
  EXPECT_NEAR(seen(all[0]).detections.at(1).yaw, -M_PI / 4, 1e-6);
  EXPECT_EQ(report.dropped.at("detection dropped: behind the camera"), 1U);
  const double first = all[1].odometry->mean.x();
  EXPECT_NE(first, 0.5);
  EXPECT_NEAR(first, 0.5, 0.1);
  import_stata(options, log());
  EXPECT_EQ(steps().at(1).odometry->mean.x(), first);
  options.noise.seed = 2;
  import_stata(options, log());
  EXPECT_NE(steps().at(1).odometry->mean.x(), first);
}

TEST_F(CameraSets, StataOracleNumbersObjectsByClassAndPlace) {
  std::string frames, detections;
  for (int i = 0; i < 5; ++i) {  // forward by 0.2 m a frame, past a cup on a chair
    const std::string index = std::to_string(i), z = std::to_string(3 - 0.2 * i);
    frames += index + " " + index + " 1 0 0 0 0 1 0 0 0 0 1 " + std::to_string(0.2 * i) + "\n";
    detections += index + " 14 0.8 0 0.1 " + z + " 0.1 1 2 3 4\n" + index + " 17 0.8 0 0.1 " + z +
                  " 0.1 1 2 3 4\n";
  }
  write("frames.txt", frames);
  write("detections.txt", detections + "4 14 0.8 1 0 2 0.1 1 2 3 4\n");
  StataOptions options;
  options.folder = folder.string();
  options.oracle_radius = 0.3;
  import_stata(options, log());
  const auto all = steps();
  ASSERT_EQ(all.size(), 5U);
  for (const auto& step : all) {
    EXPECT_EQ(seen(step).detections.at(0).true_landmark_id, 0);
    EXPECT_EQ(seen(step).detections.at(1).true_landmark_id, 1);
  }
  EXPECT_EQ(seen(all[4]).detections.at(2).true_landmark_id, mrpt::obs::INVALID_LANDMARK_ID);
}

}  // namespace
}  // namespace hybrid
