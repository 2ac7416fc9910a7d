// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <vector>

#include "tests/apps/replay_runner.h"
#include "tests/apps/scan_log.h"

namespace hybrid {
namespace {

using Json = nlohmann::json;

class BadScansTest : public ReplayTest {
 protected:
  Json replayed(const ScanLog& bad, int code = 0) {
    write_scan_log(at("bad.rawlog"), bad);
    const Json summary = summary_of(at("bad.rawlog"), code);
    // Whatever the log is like, no scan that was not counted as left out is lost.
    const std::string path = read_file(folder / "out" / "trajectory.tum");
    rows_ = static_cast<std::size_t>(std::count(path.begin(), path.end(), '\n')) - 1;  // the head
    EXPECT_EQ(path.find("nan"), std::string::npos);
    EXPECT_LT(summary.at("total_s").get<double>(), 60);
    return summary;
  }
  static std::string verdict(const Json& summary, const std::string& name) {
    const Json found = entry(summary, name);
    return found.is_null() ? "none" : found.at("verdict").get<std::string>();
  }
  /// How often something was left out or repaired, of reasons that have a word.
  static std::size_t dropped(const Json& summary, const std::string& word) {
    std::size_t count = 0;
    for (const auto& [reason, times] : summary.at("dropped").items()) {
      if (reason.find(word) != std::string::npos) count += times.get<std::size_t>();
    }
    return count;
  }
  /// Where the path of the last replay ends.
  Eigen::Vector2d end() const {
    std::ifstream file(folder / "out" / "trajectory.tum");
    std::string line, last;
    while (std::getline(file, line)) last = line;
    double t = 0, x = 0, y = 0;
    std::istringstream(last) >> t >> x >> y;
    return {x, y};
  }

  /// Whether a warning has these words.
  static bool warns(const Json& summary, const std::string& words) {
    return summary.at("warnings").dump().find(words) != std::string::npos;
  }
  double error_at_end(const ScanLog& log) const {
    return (end() - log.way.front().between(log.way.back()).translation()).norm();
  }

  std::size_t rows_ = 0;  // of trajectory.tum
};

void see_nothing(CObservation2DRangeScan& scan) {
  for (std::size_t k = 0; k < scan.getScanSize(); ++k) scan.setScanRange(k, scan.maxRange);
}

TEST_F(BadScansTest, AllAtMaximumRangeIsSaid) {
  ScanLog bad;
  bad.spoil = [](std::size_t, auto& scan) { see_nothing(scan); };
  const Json summary = replayed(bad, 2);
  EXPECT_EQ(summary.at("status"), "empty");
  const std::string message = summary.at("message");
  EXPECT_NE(message.find("scans have fewer than ten returns"), std::string::npos) << message;
  EXPECT_EQ(verdict(summary, "scans that see nothing"), "bad");
  EXPECT_EQ(rows_, bad.way.size());
}

TEST_F(BadScansTest, OneScanIsSaid) {
  ScanLog bad;
  bad.way.resize(1);
  const Json summary = replayed(bad, 2);
  EXPECT_EQ(summary.at("status"), "empty");
  EXPECT_EQ(summary.at("message"),
            "nothing was mapped: there is one scan, and only two tell a motion");
}

TEST_F(BadScansTest, OneRayIsSaid) {
  ScanLog bad;
  bad.spoil = [](std::size_t, auto& scan) { scan.resizeScan(1); };
  const Json summary = replayed(bad, 2);
  EXPECT_EQ(summary.at("status"), "empty");
  EXPECT_EQ(verdict(summary, "scans that see nothing"), "bad");
  EXPECT_EQ(rows_, bad.way.size());
}

TEST_F(BadScansTest, ScansThatAreAllNoiseAreSaid) {
  ScanLog bad;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> anywhere(1, 20);
  bad.spoil = [&](std::size_t, auto& scan) {
    for (std::size_t k = 0; k < scan.getScanSize(); ++k) scan.setScanRange(k, anywhere(random));
  };
  bad.way.resize(200);
  const Json summary = replayed(bad, 2);
  EXPECT_EQ(summary.at("status"), "empty");
  const std::string message = summary.at("message");
  EXPECT_NE(message.find("of 200 scans agree with none before them"), std::string::npos) << message;
  EXPECT_EQ(verdict(summary, "scans that agree with nothing"), "bad");
  EXPECT_EQ(rows_, bad.way.size());
}

TEST_F(BadScansTest, RangesThatAreNoNumbersAreNone) {
  ScanLog bad;
  bad.spoil = [](std::size_t i, auto& scan) {
    const float values[] = {std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity(), -1, 1e30F};
    for (std::size_t k = i % 3; k < scan.getScanSize(); k += 3) {
      scan.setScanRange(k, values[k % 4]);
      scan.setScanRangeValidity(k, true);
    }
  };
  const Json summary = replayed(bad);
  EXPECT_EQ(verdict(summary, "scans that see nothing"), "good");
  EXPECT_EQ(verdict(summary, "scans that agree with nothing"), "good");
  EXPECT_EQ(rows_, bad.way.size());
  const SE2 truth = bad.way.front().between(bad.way.back());
  EXPECT_LT((end() - truth.translation()).norm(), 0.2);
}

TEST_F(BadScansTest, MinutesAtOnePlaceAreOnePlace) {
  ScanLog bad;
  for (const bool has_odometry : {true, false}) {
    bad.has_odometry = has_odometry;
    bad.way.assign(has_odometry ? 9000 : 1500, SE2(-1, -1, 0.2));
    const Json summary = replayed(bad);
    // A scan that is left out has its row where odometry tells the pose.
    const std::size_t left_out = dropped(summary, "scan ");
    EXPECT_EQ(rows_ + (has_odometry ? 0 : left_out), bad.way.size()) << summary.at("dropped");
    EXPECT_EQ(left_out > 0, has_odometry);
    EXPECT_LT(end().norm(), 0.05);
  }
}

TEST_F(BadScansTest, TimeThatGoesBackwardsIsSaidAndLeavesTheMap) {
  ScanLog bad;
  const std::size_t half = bad.way.size() / 2;
  bad.time = [half](std::size_t i) { return 1e9 + 0.2 * double(i < half ? i : 2 * half - i); };
  const Json summary = replayed(bad);
  EXPECT_GT(dropped(summary, "went backwards"), 0U);
  const SE2 truth = bad.way.front().between(bad.way.back());
  EXPECT_LT((end() - truth.translation()).norm(), 0.2);
}

TEST_F(BadScansTest, ACorridorWithoutAnEndIsAsLongAsOdometrySays) {
  ScanLog bad;
  bad.plan = {};
  bad.plan.add_wall({-1000, -1}, {1000, -1});
  bad.plan.add_wall({-1000, 1}, {1000, 1});
  bad.way.clear();
  for (int i = 0; i < 800; ++i) bad.way.emplace_back(0.1 * i, 0, 0);
  replayed(bad);
  EXPECT_EQ(rows_, bad.way.size());
  EXPECT_NEAR(end().x(), 79.9, 1);
}

TEST_F(BadScansTest, OdometryOfAnotherRobotIsSaid) {
  ScanLog bad;
  bad.odometry = [](std::size_t i, const SE2&) {
    return SE2(0.3 * std::sin(0.05 * double(i)), 0, 0.1);
  };
  const Json summary = replayed(bad);
  EXPECT_EQ(verdict(summary, "odometry against scans"), "bad") << summary.at("health").dump(1);
  EXPECT_EQ(rows_, bad.way.size());
}

TEST_F(BadScansTest, WhereOdometryDoesNotTellScansDo) {
  ScanLog bad;
  bad.way.resize(350);
  const auto none = [](std::size_t, const SE2&) { return SE2(); };
  const auto lifted = [](std::size_t i, const SE2& motion) {
    return i > 100 && i < 130 ? SE2() : motion;
  };
  for (const auto& odometry : {std::function<SE2(std::size_t, const SE2&)>(none), {lifted}}) {
    bad.odometry = odometry;
    replayed(bad);
    EXPECT_EQ(rows_, bad.way.size());
  }
  EXPECT_LT(error_at_end(bad), 0.5);  // of wheels that were lifted on a way of 3 m
}

TEST_F(BadScansTest, ARobotThatIsCarriedBackIsFoundAgain) {
  ScanLog bad;
  const std::vector<SE2> way = bad.way;
  bad.way.resize(250);
  for (std::size_t i = 190; i < 420; ++i) bad.way.push_back(way[i] * SE2(0, 0, 0.6));
  bad.odometry = [](std::size_t i, const SE2& motion) { return i == 250 ? SE2() : motion; };
  const Json summary = replayed(bad);
  EXPECT_EQ(entry(summary, "robot that was carried").at("value"), 1);
  EXPECT_EQ(rows_, bad.way.size());
  EXPECT_LT(error_at_end(bad), 0.2);
}

TEST_F(BadScansTest, StepsWithoutOdometryAreAsInALogWithout) {
  ScanLog bad;
  bad.way.resize(350);
  bad.is_missing = [](std::size_t i) { return i % 8 == 0 || i < 30 || i > 300; };
  const Json summary = replayed(bad);
  EXPECT_EQ(dropped(summary, "scan dropped"), 0U);
  EXPECT_EQ(rows_, bad.way.size());
  EXPECT_LT(error_at_end(bad), 0.15);
}

TEST_F(BadScansTest, RaysThatAreNotAsStatedAreSaidAndUsed) {
  ScanLog bad;
  bad.way.resize(350);
  bad.spoil = [](std::size_t, auto& scan) { scan.rightToLeft = false; };
  EXPECT_TRUE(warns(replayed(bad), "fit with the other sense of rotation"));
  EXPECT_LT(error_at_end(bad), 0.15);
  bad.spoil = [](std::size_t, auto& scan) { scan.aperture = static_cast<float>(M_PI_2); };
  EXPECT_TRUE(warns(replayed(bad), "field of view of 180.0 degrees, not 90.0"));
  EXPECT_LT(error_at_end(bad), 0.15);
}

TEST_F(BadScansTest, ALaserThatIsNotLevelIsCounted) {
  ScanLog bad;
  bad.way.resize(200);
  bad.spoil = [](std::size_t i, auto& scan) {
    if (i % 3 == 1) scan.sensorPose = {0, 0, 0, 0, 0, M_PI_2};
  };
  EXPECT_GT(dropped(replayed(bad), "the laser is not level"), 60U);
  EXPECT_LT(error_at_end(bad), 0.15);
}

}  // namespace
}  // namespace hybrid
