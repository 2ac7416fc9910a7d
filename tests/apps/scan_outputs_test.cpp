// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <cmath>
#include <sstream>
#include <vector>

#include "tests/apps/replay_runner.h"
#include "tests/apps/scan_log.h"

namespace hybrid {
namespace {

using Json = nlohmann::json;

/// Cells of a text of lines, without those that begin with #.
std::vector<std::vector<std::string>> cells_of(const std::string& text, char separator) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, separator);) rows.back().push_back(cell);
  }
  return rows;
}

class ScanOutputsTest : public ReplayTest {
 protected:
  /// Two rounds along the ring of corridors.
  Json replayed(const std::string& arguments = "") {
    log_.way = testing::way_around_ring(2, 0.1);
    log_.time = [](std::size_t i) { return 1e9 + 0.25 * double(i); };
    write_scan_log(at("ring.rawlog"), log_);
    return summary_of(at("ring.rawlog") + " " + arguments);
  }
  std::string file(const std::string& name) const { return read_file(folder / "out" / name); }

  ScanLog log_;
};

TEST_F(ScanOutputsTest, TheTrajectoryHasAPoseForEveryScan) {
  const Json summary = replayed();
  const auto rows = cells_of(file("trajectory.tum"), ' ');
  ASSERT_EQ(rows.size(), log_.way.size());
  EXPECT_LT(summary.at("keyframes").get<std::size_t>(), rows.size() / 3);
  double squared = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(std::stod(rows[i][0]), log_.time(i), 1e-5);
    const SE2 truth = log_.way.front().between(log_.way[i]);
    squared += std::pow(std::stod(rows[i][1]) - truth.x(), 2) +
               std::pow(std::stod(rows[i][2]) - truth.y(), 2);
  }
  EXPECT_LT(std::sqrt(squared / double(rows.size())), 0.05);
}

TEST_F(ScanOutputsTest, LoopsHaveAllClosuresAsTheSummaryCountsThem) {
  const Json summary = replayed();
  const auto rows = cells_of(file("loops.csv"), ',');
  const std::vector<std::string> names = {
      "i",        "j",          "decision",  "inlier_probability",
      "residual", "redundancy", "checkable", "margin",
      "inliers",  "modes",      "x",         "y",
      "yaw"};
  ASSERT_FALSE(rows.empty());
  EXPECT_EQ(rows.front(), names);
  const Json& figures = summary.at("plugins");
  EXPECT_EQ(double(rows.size() - 1), figures.at("scan_closures").get<double>());
  for (std::size_t k = 1; k < rows.size(); ++k) EXPECT_TRUE(std::isfinite(std::stod(rows[k][7])));
  std::vector<std::size_t> scans;  // of keyframes
  const auto steps = cells_of(file("steps.csv"), ',');
  for (std::size_t k = 1; k < steps.size(); ++k) {
    const double time = std::stod(steps[k][1]);
    scans.push_back(static_cast<std::size_t>(std::lround((time - log_.time(0)) / 0.25)));
  }
  ASSERT_EQ(scans.size(), summary.at("keyframes").get<std::size_t>());
  double accepted = 0, near = 0;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    ASSERT_EQ(rows[r].size(), names.size());
    const std::size_t i = std::stoul(rows[r][0]), j = std::stoul(rows[r][1]);
    EXPECT_LT(i, j);
    EXPECT_LT(j, summary.at("keyframes").get<std::size_t>());
    const double p = std::stod(rows[r][3]), inliers = std::stod(rows[r][8]);
    EXPECT_TRUE(p >= 0 && p <= 1) << p;
    EXPECT_TRUE(inliers >= 0.5 && inliers <= 1) << inliers;
    if (rows[r][2] != "accepted") continue;
    ++accepted;
    EXPECT_GT(std::stod(rows[r][7]), 0);
    const SE2 measured(std::stod(rows[r][10]), std::stod(rows[r][11]), std::stod(rows[r][12]));
    const SE2 off = log_.way[scans[i]].between(log_.way[scans[j]]).between(measured);
    near += off.translation().norm() < 0.2 ? 1 : 0;
    EXPECT_LT(std::abs(off.angle()), 0.05);
  }
  EXPECT_GT(accepted, 20);
  EXPECT_GT(near, 0.9 * accepted);  // along a corridor a match tells less
  EXPECT_EQ(accepted, figures.at("scan_closures_accepted").get<double>());
}

TEST_F(ScanOutputsTest, WithoutClosuresThereIsNoListOfThem) {
  replayed("--set LaserScans.closures=no");
  EXPECT_TRUE(file("loops.csv").empty());
  EXPECT_FALSE(file("map.pgm").empty());
}

// People hide what says how far along a corridor the robot is, and the rays meet its walls in one
// pattern everywhere, so that it seems to stand. With either seed the map was 1 m off.
TEST_F(ScanOutputsTest, PeopleInACorridorDoNotHoldTheRobot) {
  for (const char* seed : {"1", "4"}) {
    SCOPED_TRACE(seed);
    const Ran made =
        run_app("hybrid-simulate -c " HYBRID_SOURCE_DIR "/config/simulate_rooms.ini --seed " +
                std::string(seed) + " -o " + at("rooms.rawlog"));
    ASSERT_EQ(made.code, 0) << made.text;
    const Json truth =
        summary_of(at("rooms.rawlog") + " --truth-path " + at("rooms_ground_truth_robot_path.txt"))
            .at("truth");
    EXPECT_LT(truth.at("trajectory").at("rmse_m").get<double>(), 0.1);
    EXPECT_LT(truth.at("nees_pose").get<double>(), 3);
  }
}

}  // namespace
}  // namespace hybrid
