// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <mrpt/core/Clock.h>
#include <mrpt/math/TPoint2D.h>
#include <mrpt/math/TPose2D.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "tests/apps/replay_runner.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

using Json = nlohmann::json;

const std::string kLog = HYBRID_SOURCE_DIR "/rawlogs/classed_demo.rawlog";
const std::string kHidden = kLog + " --set sensor.ids=none";

class ReplayHealthTest : public ReplayTest {
 protected:
  static std::size_t bad(const Json& summary) {
    std::size_t count = 0;
    for (const Json& e : summary.at("health")) count += e.at("verdict") == "bad" ? 1 : 0;
    return count;
  }
};

TEST_F(ReplayHealthTest, ARightMapIsNotCalledBadAndIsAllWell) {
  const Json summary = summary_of(kHidden + " --strict", 0);
  EXPECT_GE(summary.at("health").size(), 5U);
  EXPECT_EQ(bad(summary), 0U) << summary.at("health").dump(1);
  for (const Json& e : summary.at("health")) {
    EXPECT_TRUE(e.at("value").is_number()) << e.dump();
    EXPECT_EQ(e.at("expected").size(), 2U);
    EXPECT_FALSE(e.at("sentence").get<std::string>().empty());
  }
}

TEST_F(ReplayHealthTest, NoiseStatedTooSmallIsBadAndStrictExitsWithIt) {
  const std::string small =
      kHidden + " --set sensor.sigma_range=0.01 --set sensor.sigma_yaw_deg=0.1";
  const std::string wrong = small + " --set sensor.noise=stated";
  const Ran ran = run_replay(wrong + " --no-pictures -o " + at("out"));
  EXPECT_EQ(ran.code, 0);  // the status is what it was
  EXPECT_NE(ran.text.find("Look at:"), std::string::npos) << ran.text;
  const Json summary = summary_of(wrong + " --strict", 2);
  EXPECT_EQ(summary.at("status"), "ok");
  EXPECT_GT(bad(summary), 0U);
  EXPECT_FALSE(
      entry(summary, "noise of ranges of detections").at("knob").get<std::string>().empty());
  // By default landmarks get an extent, which makes up for the noise.
  const Json coarse = summary_of(small + " --strict", 0);
  EXPECT_EQ(bad(coarse), 0U) << coarse.at("health").dump(1);
  EXPECT_NE(coarse.at("configuration").at("BearingRangeAssociation").at("extent"), "0");
}

TEST_F(ReplayHealthTest, HalvesOfTheDetectionsAgreeAsFarAsTheNoiseIsRight) {
  const std::string halves = "halves of the detections";
  const Json right = summary_of(kLog + " --cross-check", 0);
  EXPECT_EQ(entry(right, halves).at("verdict"), "good");
  const Json wrong = summary_of(kLog +
                                    " --cross-check --set sensor.noise=stated"
                                    " --set sensor.sigma_range=0.01 --set sensor.sigma_yaw_deg=0.1",
                                0);
  EXPECT_EQ(entry(wrong, halves).at("verdict"), "bad") << entry(wrong, halves).dump();
}

/// Stamps of whole seconds: the path is wrong by half a second of driving, and nothing else says
/// so.
TEST_F(ReplayHealthTest, AClockOfWholeSecondsIsBad) {
  for (const double tick : {1.0, 0.05}) {
    Objects objects;
    for (int k = 0; k < 400; ++k) {
      const double time = 0.05 * k, stamp = std::floor(time / tick) * tick, yaw = 0.3 * time;
      objects.push_back(
          absolute_odometry(1000 + stamp, {std::sin(yaw) / 0.3, (1 - std::cos(yaw)) / 0.3, yaw}));
      if (k % 10 != 0) continue;
      auto seen = mrpt::obs::CObservationBearingRange::Create();
      seen->timestamp = mrpt::Clock::fromDouble(1000 + stamp);
      seen->sensor_std_range = seen->sensor_std_yaw = 0.01F;
      seen->sensedData.resize(1);
      const mrpt::math::TPose2D pose(std::sin(yaw) / 0.3, (1 - std::cos(yaw)) / 0.3, yaw);
      const mrpt::math::TPoint2D at = pose.inverseComposePoint({0.0, 3.0});
      seen->sensedData[0].range = static_cast<float>(std::hypot(at.x, at.y));
      seen->sensedData[0].yaw = static_cast<float>(std::atan2(at.y, at.x));
      seen->sensedData[0].landmarkID = 1;
      objects.push_back(seen);
    }
    write_log(at("clock.rawlog"), objects);
    const Json summary = summary_of(at("clock.rawlog"), 0);
    const Json repeated = entry(summary, "stamps of the odometry that repeat");
    EXPECT_EQ(repeated.is_null(), tick < 0.1) << repeated.dump();
    EXPECT_TRUE(tick < 0.1 || repeated.at("verdict") == "bad");
  }
}

TEST_F(ReplayHealthTest, OdometryThatIsTooSureIsMappedAgainAsTheMapTells) {
  const std::string sure = kHidden + " --set reader.odometry_sigma_factor=0.1";
  const Json stated = summary_of(sure + " --set sensor.noise=stated", 0);
  ASSERT_EQ(entry(stated, "path against odometry").at("verdict"), "bad");
  const Json measured = summary_of(sure + " --strict", 0);
  EXPECT_EQ(bad(measured), 0U) << measured.at("health").dump(1);
  EXPECT_EQ(measured.at("configuration").at("sensor").at("noise"), "measured");
  const Json& draws = measured.at("draws");
  ASSERT_GT(draws.size(), 1U);
  EXPECT_TRUE(draws[0].at("settings").empty());
  EXPECT_EQ(draws[0].at("health"), "bad");
  EXPECT_EQ(draws[0].at("work"), 1);
  EXPECT_NE(draws[1].at("settings").dump().find("sensor.noise=measured"), std::string::npos);
  int taken = 0;
  for (const Json& draw : draws) taken += draw.at("taken").get<bool>() ? 1 : 0;
  EXPECT_EQ(taken, 1);
  const Json right = summary_of(kHidden, 0);
  EXPECT_EQ(measured.at("landmarks"), right.at("landmarks"));
}

TEST_F(ReplayHealthTest, TwoIdsOfTheTruthThatWereExchangedAreNamed) {
  const std::string truth = HYBRID_SOURCE_DIR "/rawlogs/classed_demo_ground_truth.txt";
  std::ifstream file(truth);
  std::string text, line;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string x, y, z, a, b, c, id, rest;
    if (line[0] != '%' && words >> x >> y >> z >> a >> b >> c >> id) {
      std::getline(words, rest);
      id = id == "2" ? "3" : id == "3" ? "2" : id;
      line = x + " " + y + " " + z + " " + a + " " + b + " " + c + " " + id;
    }
    text += line + "\n";
  }
  const std::string path = HYBRID_SOURCE_DIR "/rawlogs/classed_demo_ground_truth_robot_path.txt";
  const std::string known = kLog + " --truth-path " + path + " --truth-map ";
  const Json mixed = summary_of(known + write("mixed.txt", text), 0);
  ASSERT_EQ(mixed.at("warnings").size(), 1U);
  const std::string warning = mixed.at("warnings")[0];
  EXPECT_NE(warning.find("landmarks 2 and 3 of the truth fit if exchanged"), std::string::npos)
      << warning;
  EXPECT_EQ(summary_of(known + truth, 0).at("warnings").size(), 0U);
}

}  // namespace
}  // namespace hybrid
