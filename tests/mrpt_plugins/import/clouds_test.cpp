// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/clouds.h"

#include <mrpt/obs/CObservationPointCloud.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "mrpt_plugins/evaluation/ground_truth.h"
#include "tests/mrpt_plugins/import/import_files.h"
#include "tests/support/depth_png.h"

namespace hybrid {
namespace {

using Cloud = std::vector<std::array<float, 3>>;

const Cloud kCloud{{1, 2, 3}, {-4.5F, 0.5F, 6}};

std::string bytes_of(const Cloud& cloud, bool has_intensity) {
  std::string out;
  for (const auto& [x, y, z] : cloud) {
    const float values[] = {x, y, z, 0.5F};
    out.append(reinterpret_cast<const char*>(values), has_intensity ? 16 : 12);
  }
  return out;
}

/// A cloud of one point, x metres ahead.
std::string ahead(float x) {
  return bytes_of({{x, 0, 0}}, true);
}

class Clouds : public ImportTest {
 protected:
  Clouds() {
    std::filesystem::create_directory(at("in"));
    options.folder = at("in");
  }

  ImportReport import() { return import_clouds(options, log()); }

  /// Steps with their points as seen from the robot.
  std::vector<LogStep> clouds() const {
    RawlogOptions reading;
    reading.request.points = true;
    reading.request.classes = {"CObservationPointCloud"};
    RawlogReader reader(log(), reading);
    std::vector<LogStep> all;
    while (auto step = reader.next()) all.push_back(std::move(*step));
    EXPECT_EQ(reader.status(), LogStatus::kComplete) << reader.message();
    return all;
  }

  static void expect_points(const LogStep& step, const Cloud& expected) {
    ASSERT_EQ(step.points.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_NEAR(step.points[i].x, expected[i][0], 1e-4) << i;
      EXPECT_NEAR(step.points[i].y, expected[i][1], 1e-4) << i;
      EXPECT_NEAR(step.points[i].z, expected[i][2], 1e-4) << i;
    }
  }

  /// Three clouds, and a file of poses.
  std::string with_three(const std::string& poses) {
    for (const char* name : {"in/0.bin", "in/1.bin", "in/2.bin"}) write(name, ahead(1));
    return write("poses.txt", poses);
  }

  CloudsOptions options;
};

TEST_F(Clouds, OfEachForm) {
  const std::string pcd =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n"
      "POINTS 2\nDATA ";
  write("in/1.bin", bytes_of(kCloud, true));
  write("in/2.pcd", pcd + "ascii\n1 2 3\n-4.5 .5 6\n");
  write("in/3.PCD", pcd + "binary\n" + bytes_of(kCloud, false));
  write("in/4.ply",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n1 2 3\n-4.5 .5 6\n");
  write("in/preview.png", "no picture");
  write("in/times.txt", "1 2 3");
  const ImportReport report = import();
  EXPECT_EQ(report.steps, 4U);
  EXPECT_TRUE(tells(report, "files that are no clouds are left aside: 2, such as times.txt"));
  EXPECT_TRUE(tells(report, "4 clouds with 8 points, of which 8 are kept"));
  EXPECT_EQ(count_notes(report, "intensities"), 1);
  expect_progress(4);
  const auto all = clouds();
  ASSERT_EQ(all.size(), 4U);
  for (const LogStep& step : all) {
    expect_points(step, kCloud);
    EXPECT_NEAR(step.time, 0.1 * static_cast<double>(step.index), 1e-6);
    EXPECT_FALSE(step.odometry);
    ASSERT_EQ(step.observations.size(), 1U);
    EXPECT_EQ(step.observations[0]->sensorLabel, "LIDAR");
  }
}

TEST_F(Clouds, DepthImagesInAxesOfTheRobot) {
  write("in/0.png", depth_png(4, {0, 0, 2000, 0, 0, 0, 1000, 9000}));
  write("in/1.png", depth_png(4, std::vector<std::uint16_t>(8, 0)));
  options.focal = 2;
  options.max_range = 5;
  options.center_v = 0;
  const ImportReport report = import();
  EXPECT_EQ(report.dropped.at("point dropped: beyond the maximum range"), 1U);
  EXPECT_EQ(report.dropped.at("cloud kept without points: it has none"), 1U);
  const auto all = clouds();
  ASSERT_EQ(all.size(), 2U);
  expect_points(all[0], {{2, 0, 0}, {1, 0, -0.5F}});
  expect_points(all[1], {});
  EXPECT_EQ(all[0].observations[0]->sensorLabel, "DEPTH");
  options.center_u = 3;
  import();
  expect_points(clouds()[0], {{2, 1, 0}, {1, 0.5F, -0.5F}});
  options.focal = 0;
  std::filesystem::remove(log());
  expect_error([&] { import(); }, "depth images need --focal");
}

TEST_F(Clouds, InTheNaturalOrderOfTheirNames) {
  write("in/scan10.bin", ahead(10));
  write("in/scan9.bin", ahead(9));
  write("in/scan010.bin", ahead(10));
  write("in/scan1_2.bin", ahead(1.2F));
  write("in/scan1_11.bin", ahead(1.5F));
  write("in/100.bin", ahead(0.5F));
  import();
  std::vector<float> order;
  for (const LogStep& step : clouds()) order.push_back(step.points.at(0).x);
  EXPECT_EQ(order, std::vector<float>({0.5F, 1.2F, 1.5F, 9, 10, 10}));
}

TEST_F(Clouds, NamesThatAreTimes) {
  for (const char* name : {"in/10.5.bin", "in/10.25.bin", "in/9.9.bin", "in/12.0.bin"}) {
    write(name, ahead(1));
  }
  import();
  EXPECT_NEAR(clouds()[2].time, 10.5, 1e-6);
  options.odometry = write("poses.txt", "10 0 0 0 0 0 0 1\n11 4 0 0 0 0 0 1\n");
  options.truth = write("truth.txt", "9.9 3 0 0 0 0 0 1\n10.5 7 0 0 0 0 0 1\n13 8 0 0 0 0 0 1\n");
  const ImportReport report = import();
  EXPECT_EQ(report.dropped.at("cloud dropped: no pose before or after it"), 2U);
  const auto all = clouds();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_NEAR(all[0].time, 10.25, 1e-6);
  EXPECT_NEAR(all[1].odometry.value().mean.x(), 1, 1e-9);
  EXPECT_NEAR(read_true_path(report.files[1])[1].x(), 7, 1e-6);
  std::filesystem::remove(log());
  options.truth = write("truth.txt", "1e9 3 0 0 0 0 0 1\n");
  expect_error([&] { import(); }, "clouds are of 9.9 to 12 s, poses of 1000000000 to");
}

TEST_F(Clouds, DamagedOnesAreDroppedAndTold) {
  options.odometry = write("poses.txt",
                           "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 3 0 0 0 0 0 1\n"
                           "3 6 0 0 0 0 0 1\n");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  write("in/0.bin", bytes_of({{1, 0, 0}, {nan, 0, 0}}, true));
  write("in/1.bin", ahead(1) + "x");
  write("in/2.pcd", "FIELDS x y z\nPOINTS 2\nDATA ascii\n1 2 3\n");
  write("in/3.bin", "");
  const ImportReport report = import();
  EXPECT_EQ(report.dropped.at("cloud dropped: its file cannot be read"), 2U);
  EXPECT_EQ(report.dropped.at("point dropped: not finite"), 1U);
  EXPECT_EQ(report.dropped.at("cloud kept without points: it has none"), 1U);
  EXPECT_TRUE(tells(report, "1.bin: 17 bytes"));
  EXPECT_TRUE(tells(report, "2.pcd:4:6: the header says 2 points, the file ends after 1"));
  const auto all = clouds();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_NEAR(all[1].time, 3, 1e-6);
  EXPECT_NEAR(all[1].odometry.value().mean.x(), 6, 1e-9) << "over the clouds that are dropped";
}

TEST_F(Clouds, WithoutAnyThatCanBeRead) {
  write("in/notes.txt", "");
  expect_error([&] { import(); }, at("in") + ": no clouds; expected is a file for each");
  write("in/0.bin", "short");
  expect_error([&] { import(); }, "none of 1 clouds can be read; the first: " + at("in/0.bin"));
  options.folder = at("absent");
  expect_error([&] { import(); }, at("absent"));
}

TEST_F(Clouds, OnePoseForEach) {
  options.truth = with_three("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n");
  expect_error([&] { import(); }, "poses.txt: 2 poses, and " + at("in") + " has 3 clouds");
  options.truth = with_three("1 2 3\n");
  expect_error([&] { import(); }, "poses.txt:1:1: 3 columns; poses have 8 columns");
  options.truth = with_three("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1\n");
  expect_error([&] { import(); }, "poses.txt:2:8: 4 columns; 12 are expected");
}

TEST_F(Clouds, MotionsOfRowsOfTumWithTheirTimes) {
  const double s = std::sqrt(0.5);
  const std::string turned = " 0 0 " + std::to_string(s) + " " + std::to_string(s) + "\n";
  options.odometry = with_three("5 1 0 0 0 0 0 1\n5.5 2 0 0" + turned + "6.5 2 1 0" + turned);
  options.walk_translation = 0.1;
  options.walk_rotation = 0.2;
  import();
  const auto all = clouds();
  ASSERT_EQ(all.size(), 3U);
  EXPECT_FALSE(all[0].odometry);
  const OdometryIncrement& first = all[1].odometry.value();
  EXPECT_FALSE(first.is_planar);
  EXPECT_NEAR(first.mean.x(), 1, 1e-6);
  EXPECT_NEAR(first.mean.yaw(), M_PI_2, 1e-6);
  EXPECT_NEAR(first.covariance(0, 0), 0.01, 1e-5);
  EXPECT_NEAR(first.covariance(5, 5), 0.04, 1e-5);
  EXPECT_NEAR(all[2].odometry.value().mean.x(), 1, 1e-6) << "ahead after the turn";
  EXPECT_NEAR(all[2].time, 6.5, 1e-6);
}

TEST_F(Clouds, MotionsOfMatrices) {
  const std::string at_1 = "1 0 0 1 0 1 0 2 0 0 1 3", last = " 0 0 0 1\n";
  const std::string at_0 = "1 0 0 0 0 1 0 0 0 0 1 0", at_2 = "1 0 0 2 0 1 0 4 0 0 1 6";
  const std::string rows =
      "1,0,0,0,\n0,1,0,0,\n0,0,1,0,\n0,0,0,7.5,\n1,0,0,1,\n0,1,0,2,\n0,0,1,3,\n"
      "0,0,0,8,\n1,0,0,2,\n0,1,0,4,\n0,0,1,6,\n0,0,0,9,\n";
  for (const std::string& text :
       {at_0 + "\n" + at_1 + "\n" + at_2 + "\n", at_0 + last + at_1 + last + at_2 + last,
        "0 " + at_0 + last + "2 " + at_1 + last + "4 " + at_2 + last, rows}) {
    options.odometry = with_three(text);
    options.period = 0.5;
    import();
    const auto all = clouds();
    ASSERT_EQ(all.size(), 3U);
    EXPECT_NEAR(all[1].time - all[0].time, 0.5, 1e-6);
    EXPECT_NEAR(all[0].time, text == rows ? 7.5 : 0, 1e-6);
    for (const std::size_t i : {1U, 2U}) {
      EXPECT_NEAR(all[i].odometry.value().mean.x(), 1, 1e-9);
      EXPECT_NEAR(all[i].odometry.value().mean.y(), 2, 1e-9);
      EXPECT_NEAR(all[i].odometry.value().mean.z(), 3, 1e-9);
    }
  }
}

TEST_F(Clouds, PosesOfCamerasAreTurnedIntoAxesOfTheRobot) {
  const std::string rows =
      "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 2 0 0 1 3\n1 0 0 1 0 1 0 2 0 0 1 3\n";
  options.truth = options.odometry = with_three(rows);
  options.camera_odometry = options.camera_truth = true;
  import();
  const auto motion = clouds()[1].odometry.value().mean;
  EXPECT_NEAR(motion.x(), 3, 1e-9);
  EXPECT_NEAR(motion.y(), -1, 1e-9);
  EXPECT_NEAR(motion.z(), -2, 1e-9);
  const auto truth = read_true_path(at("out_ground_truth_robot_path.txt"));
  ASSERT_EQ(truth.size(), 3U);
  EXPECT_NEAR(truth[2].x(), 3, 1e-6);
  EXPECT_NEAR(truth[2].z(), -2, 1e-6);
}

TEST_F(Clouds, ASensorOnItsRobot) {
  options.odometry = with_three("0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n");
  options.truth = options.odometry;
  options.sensor_pose = {0.5, 0, 1, M_PI_2, 0, 0};
  const ImportReport report = import();
  ASSERT_EQ(report.files.size(), 2U);
  const auto all = clouds();
  expect_points(all[1], {{0.5F, 1, 1}});
  EXPECT_NEAR(all[1].odometry.value().mean.x(), 1, 1e-9) << "poses are of the robot";
  EXPECT_NEAR(read_true_path(report.files[1])[1].x(), 1, 1e-6);
  options.sensor_pose = {1, 2};
  std::filesystem::remove(log());
  expect_error([&] { import(); }, "six numbers");
}

TEST_F(Clouds, ManyPointsAreThinned) {
  Cloud many;
  for (int i = 0; i < 1000; ++i) many.push_back({1 + 0.01F * static_cast<float>(i), 0, 0});
  write("in/0.bin", bytes_of(many, true));
  options.most_points = 100;
  const ImportReport report = import();
  const std::string first = read("out.rawlog");
  const std::size_t kept = clouds()[0].points.size();
  EXPECT_LE(kept, 100U);
  EXPECT_GT(kept, 80U);
  EXPECT_EQ(report.dropped.at("point dropped: another one of its voxel is kept"), 1000 - kept);
  import();
  EXPECT_EQ(read("out.rawlog"), first);
  options.most_points = 0;
  import();
  EXPECT_EQ(clouds()[0].points.size(), 1000U);
}

}  // namespace
}  // namespace hybrid
