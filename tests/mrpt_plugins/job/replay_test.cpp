// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/replay.h"

#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/job/run_summary.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

const std::string kDemo = HYBRID_SOURCE_DIR "/rawlogs/classed_demo";

class Replay : public ScratchFolder {
 protected:
  ReplayRequest request() const {
    ReplayRequest request;
    request.rawlog = kDemo + ".rawlog";
    request.output = at("out");
    request.pictures = false;
    return request;
  }
  nlohmann::json summary() const { return nlohmann::json::parse(read("out/summary.json")); }
  /// The names of the files of a folder, all in one line.
  std::string files(const std::string& name) const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(at(name))) {
      names.insert(entry.path().filename().string());
    }
    std::string text;
    for (const std::string& file : names) text += file + " ";
    return text;
  }
  /// The message of a replay that fails.
  std::string failure(const ReplayRequest& request) const {
    try {
      replay(request);
    } catch (const Error& e) {
      return e.what();
    }
    ADD_FAILURE() << "no error";
    return "";
  }
};

TEST(Findings, NameTheRobotWhoseOdometryContradictsItsSensor) {
  ReplaySettings settings;
  settings.robots.resize(2);
  settings.robots[0].name = "anna";
  settings.robots[1].name = "bert";
  Health health;
  judge_findings(settings, health);
  EXPECT_TRUE(health.empty());
  AlignmentRecord record;
  record.sensor = "camera";
  record.mirrored = true;
  settings.robots[1].findings.alignment = {record};
  judge_findings(settings, health);
  ASSERT_EQ(health.size(), 1U);
  EXPECT_EQ(worst(health), HealthVerdict::kDoubtful);  // so that another map is made
  EXPECT_NE(health[0].sentence.find("bert camera: bearings"), std::string::npos);
  // A map that has it corrected is not doubted for that.
  settings.robots[1].source.correction.sensors["camera"].mirrored = true;
  health.clear();
  judge_findings(settings, health);
  EXPECT_TRUE(health.empty());
}

TEST_F(Replay, JudgesWhetherWhatWasMeasuredFarApartInTimeAgrees) {
  ReplayRequest asked = request();
  replay(asked);
  const nlohmann::json right = summary().at("health").at(0);
  EXPECT_EQ(right.at("name"), "agreement over time");
  EXPECT_EQ(right.at("verdict"), "good") << right.at("sentence");
  EXPECT_NEAR(right.at("value"), 1, 0.1);
  EXPECT_GT(right.at("over_time").size(), 2U);
  // Odometry that is stated to be all but exact: the path is that of dead reckoning.
  asked.settings = {"sensor.noise=stated", "reader.odometry_sigma_factor=0.01"};
  replay(asked);
  const nlohmann::json wrong = summary().at("health").at(0);
  EXPECT_EQ(wrong.at("name"), "agreement over time");
  EXPECT_EQ(wrong.at("verdict"), "bad") << wrong.at("sentence");
  EXPECT_LT(wrong.at("value"), 0.5);
}

TEST_F(Replay, IsNotJudgedWhereNothingIsInViewAgain) {
  ReplayRequest asked = request();
  asked.settings = {"keyframes.min_distance=1000", "keyframes.min_angle_deg=0",
                    "keyframes.min_time=0"};
  replay(asked);
  const nlohmann::json entry = summary().at("health").at(0);
  EXPECT_EQ(entry.at("verdict"), "not judged");
  EXPECT_TRUE(entry.at("value").is_null());
  EXPECT_FALSE(entry.contains("over_time"));
}

TEST_F(Replay, TellsOfItselfAndThenOfTheFiles) {
  ReplayRequest asked = request();
  asked.truth_path = kDemo + "_ground_truth_robot_path.txt";
  std::size_t keyframes = 0;
  int published = 0;
  const ReplayOutcome outcome = replay(
      asked,
      [&](const ReplayProgress& progress) {
        EXPECT_EQ(progress.keyframes, ++keyframes);
        EXPECT_FALSE(std::filesystem::exists(at("out/summary.json")));
      },
      [&](const ReplayOutcome& there) {
        ++published;
        EXPECT_TRUE(std::filesystem::exists(there.folder / "summary.json"));
      });
  EXPECT_EQ(published, 1);
  EXPECT_EQ(outcome.signal, 0);
  EXPECT_EQ(outcome.summary.status, "ok");
  EXPECT_EQ(outcome.summary.keyframes, keyframes);
  EXPECT_EQ(summary().at("keyframes"), keyframes);
  EXPECT_EQ(summary().at("objective"), outcome.summary.objective);
  EXPECT_EQ(files("out"),
            "graph.g2o landmarks.csv landmarks.json steps.csv summary.json trajectory.tum "
            "trajectory_dead_reckoning.tum trajectory_truth.tum ");
}

TEST_F(Replay, AFailureUnderWayLeavesTheOldResult) {
  replay(request());
  const std::string before = read("out/summary.json");
  const auto fail = [](const ReplayProgress& progress) {
    if (progress.keyframes == 5) throw std::runtime_error("enough");
  };
  ReplayRequest asked = request();
  asked.events = true;  // a file that is written as the log goes
  EXPECT_THROW(replay(asked, fail), std::runtime_error);
  EXPECT_EQ(read("out/summary.json"), before);
  EXPECT_EQ(files("out").find("events"), std::string::npos) << files("out");
  asked.output = at("new");
  EXPECT_THROW(replay(asked, fail), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(at("new")));
}

TEST_F(Replay, AFailureBeforeTheFirstKeyframeNamesTheFile) {
  ReplayRequest asked = request();
  asked.truth_path = write("bad.tum", "1 2 three\n");
  EXPECT_NE(failure(asked).find("bad.tum"), std::string::npos);
  asked = request();
  asked.map_mode = "extend";
  EXPECT_NE(failure(asked).find("need a map file"), std::string::npos);
  asked.map = at("none.hmap");
  EXPECT_NE(failure(asked).find("none.hmap"), std::string::npos);
  asked = request();
  asked.rawlog = at("none.rawlog");
  EXPECT_NE(failure(asked).find("none.rawlog"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(at("out")));
}

TEST_F(Replay, AFailureOfTheMapFileLeavesNoResult) {
  ReplayRequest asked = request();
  asked.map = at("a.hmap");
  asked.settings = {"solver.mode=batch"};
  EXPECT_NE(failure(asked).find("a map file needs [solver] mode"), std::string::npos);
  asked.settings.clear();
  replay(asked);
  EXPECT_TRUE(summary().at("localized_at").is_null());
  const std::string before = read("out/summary.json"), map = read("a.hmap");
  EXPECT_NE(failure(asked).find("would count twice"), std::string::npos);
  EXPECT_EQ(read("out/summary.json"), before);
  EXPECT_EQ(read("a.hmap"), map);
}

TEST_F(Replay, OfADamagedLogIsPartial) {
  const std::string whole = [] {
    std::ifstream in(kDemo + ".rawlog", std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(in), {}};
  }();
  ReplayRequest asked = request();
  asked.rawlog = write("half.rawlog", whole.substr(0, whole.size() / 2));
  const ReplayOutcome outcome = replay(asked);
  EXPECT_EQ(outcome.summary.status, "partial");
  EXPECT_FALSE(outcome.summary.message.empty());
  EXPECT_EQ(summary().at("status"), "partial");
  EXPECT_GT(outcome.summary.keyframes, 0U);
  asked.rawlog = write("none.rawlog", "");
  EXPECT_NE(failure(asked).find("none.rawlog"), std::string::npos);
  EXPECT_EQ(summary().at("status"), "partial");  // the old result stays
}

TEST_F(Replay, DrawsAsManyFramesAsAsked) {
  ReplayRequest asked = request();
  asked.frames = 3;
  replay(asked);
  EXPECT_EQ(files("out/frames"), "frame_0001.png frame_0002.png frame_0003.png ");
}

}  // namespace
}  // namespace hybrid
