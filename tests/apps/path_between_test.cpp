// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Between keyframes far apart, the path is that of the odometry.

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <sstream>

#include "tests/apps/replay_runner.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose2D;

constexpr double kStart = 1e9, kRadius = 5, kRate = 0.12;  // s, m, rad/s
constexpr double kNear = 0.05;                             // m

CPose2D true_pose(double t) {
  return {kRadius * std::sin(kRate * t), kRadius * (1 - std::cos(kRate * t)), kRate * t};
}

/// A robot on a circle that sees six landmarks at some times only.
struct Circle {
  double seconds = 60, detects_every = 5;
  double scale = 1.01;  // of the odometry
  /// Adds what stands for the reading of odometry at a time.
  std::function<void(double, Objects&)> read = [this](double t, Objects& log) {
    log.push_back(reading(t));
  };

  mrpt::obs::CObservation::Ptr reading(double t) const {
    const CPose2D pose = true_pose(t);
    return absolute_odometry(kStart + t, {scale * pose.x(), scale * pose.y(), pose.phi()});
  }
  static mrpt::obs::CObservation::Ptr detections(double t) {
    auto seen = mrpt::obs::CObservationBearingRange::Create();
    seen->timestamp = mrpt::Clock::fromDouble(kStart + t);
    seen->sensor_std_range = 0.02F;
    seen->sensor_std_yaw = 0.004F;
    const CPose2D pose = true_pose(t);
    for (int id = 0; id < 6; ++id) {
      const double angle = M_PI / 3 * id, dx = 7 * std::cos(angle) - pose.x(),
                   dy = kRadius + 7 * std::sin(angle) - pose.y();
      seen->sensedData.push_back(
          {static_cast<float>(std::hypot(dx, dy)),
           static_cast<float>(std::remainder(std::atan2(dy, dx) - pose.phi(), 2 * M_PI)),
           0.0F,
           id,
           {}});
    }
    return seen;
  }
  Objects log() const {
    Objects out;
    const int readings = static_cast<int>(std::lround(10 * seconds));
    const int every = static_cast<int>(std::lround(10 * detects_every));
    for (int i = 0; i <= readings; ++i) {
      read(0.1 * i, out);
      if (i % every == 2) out.push_back(detections(0.1 * i + 0.03));
    }
    return out;
  }
};

/// Rows of a path: time since the start of the log, x and y.
using Row = std::array<double, 3>;

class PathBetween : public ReplayTest {
 protected:
  std::vector<Row> rows(const std::string& name) const {
    std::vector<Row> out;
    std::istringstream lines(read_file(folder / name));
    for (std::string line; std::getline(lines, line);) {
      if (line[0] == '#') continue;
      std::istringstream words(line);
      Row row{};
      words >> row[0] >> row[1] >> row[2];
      row[0] -= kStart;
      out.push_back(row);
    }
    return out;
  }
  std::vector<Row> replayed(const Circle& circle, const std::string& more = "") const {
    write_log(at("circle.rawlog"), circle.log());
    summary_of(at("circle.rawlog") + more);
    return rows("out/trajectory.tum");
  }
  /// The path of the true circle, moved so that it begins at the first keyframe.
  static void expect_on_circle(const std::vector<Row>& path) {
    const CPose2D first = true_pose(path.front()[0]);
    for (const Row& row : path) {
      const CPose2D at = first + CPose2D(row[1], row[2], 0);
      const CPose2D truth = true_pose(row[0]);
      EXPECT_LT(std::hypot(at.x() - truth.x(), at.y() - truth.y()), kNear) << row[0] << " s";
    }
    for (std::size_t i = 1; i < path.size(); ++i) EXPECT_GT(path[i][0], path[i - 1][0]);
  }
  /// Places of the poses of the graph.
  std::vector<std::array<double, 2>> poses() const {
    std::vector<std::array<double, 2>> out;
    std::istringstream lines(read_file(folder / "out/graph.g2o"));
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string tag, id;
      std::array<double, 2> at{};
      words >> tag >> id >> at[0] >> at[1];
      if (tag == "VERTEX_SE2") out.push_back(at);
    }
    return out;
  }
};

TEST_F(PathBetween, HasAPoseForEachReadingOnTheArc) {
  const Circle circle;
  const std::vector<Row> path = replayed(circle);
  expect_on_circle(path);
  EXPECT_NEAR(path.front()[0], 0.23, 1e-6);
  EXPECT_NEAR(path.back()[0], 60, 1e-6) << "the odometry goes on after the last keyframe";
  EXPECT_EQ(path.size(), 598U + 12U);
  std::set<std::array<double, 2>> places;
  for (const Row& row : path) places.insert({row[1], row[2]});
  const auto keyframes = poses();
  ASSERT_EQ(keyframes.size(), 12U);
  for (const auto& keyframe : keyframes) EXPECT_EQ(places.count(keyframe), 1U) << "as it is";
  const auto reckoned = rows("out/trajectory_dead_reckoning.tum");
  EXPECT_EQ(reckoned.size(), path.size());
}

TEST_F(PathBetween, OnlyKeyframesAreJudged) {
  const Circle circle;
  std::string truth = "%\n";
  for (int k = 0; k < 12; ++k) {
    const CPose2D pose = true_pose(5.0 * k + 0.23);
    truth += std::to_string(kStart + 5.0 * k + 0.23) + " " + std::to_string(pose.x()) + " " +
             std::to_string(pose.y()) + " 0 0 0 " + std::to_string(std::sin(pose.phi() / 2)) + " " +
             std::to_string(std::cos(pose.phi() / 2)) + "\n";
  }
  replayed(circle, " --truth-path " + write("truth.tum", truth));
  EXPECT_EQ(rows("out/trajectory_truth.tum").size(), 12U);
}

TEST_F(PathBetween, DrawnPathsAreNoChords) {
  Circle circle;
  write_log(at("circle.rawlog"), circle.log());
  const Ran ran = run_replay(at("circle.rawlog") +
                             " --set 'map.origin=40 -4 0' --picture-format svg "
                             "--frames 2 --report -o " +
                             at("out"));
  ASSERT_EQ(ran.code, 0) << ran.text;
  const auto globe = nlohmann::json::parse(read("out/map.geojson"));
  for (const auto& feature : globe["features"]) {
    if (feature["geometry"]["type"] != "LineString") continue;
    const std::size_t points = feature["geometry"]["coordinates"].size();
    EXPECT_GT(points, 50U);
    EXPECT_LT(points, 200U) << "no point that one cannot see";
  }
}

TEST_F(PathBetween, DoubledOdometryHasItsRowsOnce) {
  Circle circle;
  circle.read = [&](double t, Objects& log) {
    log.push_back(circle.reading(t));
    log.push_back(circle.reading(t));
  };
  const std::vector<Row> path = replayed(circle);
  expect_on_circle(path);
  EXPECT_EQ(path.size(), 610U);
}

TEST_F(PathBetween, OdometryThatComesLateHasItsRows) {
  Circle circle;
  circle.read = [&](double t, Objects& log) {
    if (t >= 1) log.push_back(circle.reading(t - 1));
  };
  const std::vector<Row> path = replayed(circle);
  expect_on_circle(path);
  EXPECT_GT(path.size(), 590U);
}

TEST_F(PathBetween, AGapHasNoRows) {
  Circle circle;
  circle.read = [&](double t, Objects& log) {
    if (t < 21.05 || t > 24.05) log.push_back(circle.reading(t));
  };
  const std::vector<Row> path = replayed(circle);
  expect_on_circle(path);
  EXPECT_EQ(path.size(), 580U);
  for (const Row& row : path) EXPECT_FALSE(row[0] > 21.05 && row[0] < 24.05);
}

TEST_F(PathBetween, AClockThatStandsStillHasNoRows) {
  Circle circle;
  circle.read = [&](double t, Objects& log) {  // of a coarse clock
    auto reading = circle.reading(t);
    reading->timestamp = mrpt::Clock::fromDouble(kStart + std::floor(t / 10) * 10);
    log.push_back(reading);
  };
  const std::vector<Row> path = replayed(circle);
  for (std::size_t i = 1; i < path.size(); ++i) EXPECT_GT(path[i][0], path[i - 1][0]);
  EXPECT_LT(path.size(), 25U);
}

TEST_F(PathBetween, WithoutOdometryThereAreKeyframesOnly) {
  Circle circle;
  circle.read = [](double, Objects&) {};
  EXPECT_EQ(replayed(circle).size(), 12U);
  EXPECT_EQ(rows("out/trajectory_dead_reckoning.tum").size(), 12U);
}

TEST_F(PathBetween, AStreamHasTheSameRows) {
  write_log(at("circle.rawlog"), Circle().log());
  const std::string settings =
      " --set map.dimension=2 --set plugins.classes=BearingRangeKnownIds --no-pictures";
  ASSERT_EQ(run_replay(at("circle.rawlog") + settings + " -o " + at("out")).code, 0);
  ASSERT_EQ(run_replay("--rawlog - --stream" + settings + " -o " + at("piped") + " < " +
                       at("circle.rawlog") + " > /dev/null")
                .code,
            0);
  for (const char* name : {"trajectory.tum", "trajectory_dead_reckoning.tum"}) {
    EXPECT_EQ(read(std::string("piped/") + name), read(std::string("out/") + name));
  }
}

TEST_F(PathBetween, InAKnownMapTheRowsAreInIt) {
  const std::string map = " --set map.file=" + at("a.hmap");
  const std::vector<Row> built = replayed({}, map);
  const std::vector<Row> known = replayed({}, map + " --set map.mode=localize");
  ASSERT_EQ(known.size(), built.size());
  for (std::size_t i = 0; i < built.size(); ++i) {
    EXPECT_LT(std::hypot(known[i][1] - built[i][1], known[i][2] - built[i][2]), kNear);
  }
}

TEST_F(PathBetween, TablesKeepTheirOdometry) {
  std::ostringstream odometry, detections;
  odometry << "time,x,y,yaw\n";
  detections << "time,range,yaw,id\n";
  for (int i = 0; i <= 600; ++i) {
    const CPose2D pose = true_pose(0.1 * i);
    odometry << 0.1 * i << ',' << pose.x() << ',' << pose.y() << ',' << kRate * 0.1 * i << '\n';
    if (i % 20 != 2) continue;
    const auto seen = std::dynamic_pointer_cast<mrpt::obs::CObservationBearingRange>(
        Circle::detections(0.1 * i + 0.03));
    for (const auto& d : seen->sensedData) {
      detections << 0.1 * i + 0.03 << ',' << d.range << ',' << d.yaw << ',' << d.landmarkID << '\n';
    }
  }
  const Ran ran =
      run_app("hybrid-import csv --odometry " + write("o.csv", odometry.str()) + " --detections " +
              write("d.csv", detections.str()) + " -o " + at("tables.rawlog"));
  ASSERT_EQ(ran.code, 0) << ran.text;
  const auto summary = summary_of(at("tables.rawlog"));
  EXPECT_EQ(summary["keyframes"], 30);
  EXPECT_TRUE(summary["warnings"].empty()) << summary["warnings"];
  std::vector<Row> path = rows("out/trajectory.tum");
  for (Row& row : path) row[0] += kStart;
  EXPECT_EQ(path.size(), 598U + 30U);
  expect_on_circle(path);
}

}  // namespace
}  // namespace hybrid
