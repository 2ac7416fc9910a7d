// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A replay that makes a map is killed, or its disk is full, at calls that change the disk.

#include <nlohmann/json.hpp>

#include "tests/faults/injection.h"

namespace hybrid {
namespace {

constexpr int kEvery = 10;  // keyframes between two writes to the map

class MapFaults : public InjectionTest {
 protected:
  std::string command(const std::string& map, const std::string& out) const {
    return "hybrid-replay --no-pictures -c " HYBRID_SOURCE_DIR "/config/classed_demo.ini --map " +
           at(map) + " -o " + at(out);
  }
  nlohmann::json info_of(const std::string& map) const {
    const Ran ran = run_app("hybrid-map info --json " + at(map));
    EXPECT_EQ(ran.code, 0) << ran.text;
    return nlohmann::json::parse(ran.text, nullptr, false);
  }
  std::string content(const std::string& map) const {
    const Ran ran = run_app("hybrid-map export --no-pictures -o " + at("export") + " " + at(map));
    EXPECT_EQ(ran.code, 0) << ran.text;
    return read("export/landmarks.csv") + read("export/trajectory_1.tum");
  }
  /// Goes on with a map that was left at any moment, and expects what an undisturbed run gives.
  void expect_resumes(const std::string& whole) const {
    const bool there = run_app("hybrid-map info " + at("a.hmap")).code == 0;
    bool complete = false;
    if (there) {
      const auto sessions = info_of("a.hmap")["sessions"];
      EXPECT_LE(sessions.size(), 1u);
      complete = !sessions.empty() && sessions[0]["complete"];
      if (!sessions.empty() && !complete) {
        EXPECT_EQ(sessions[0]["keyframes"].get<int>() % kEvery, 0);
      }
    }
    if (!complete) {
      const Ran ran = run_app(command("a.hmap", "again") + " --resume");
      EXPECT_EQ(ran.code, 0) << ran.text;
    }
    EXPECT_EQ(content("a.hmap"), whole);
  }
};

TEST_F(MapFaults, AMapOutlivesBeingKilled) {
  ASSERT_EQ(run_app(command("whole.hmap", "out")).code, 0);
  const std::string whole = content("whole.hmap");
  const long calls = count({"disk", "9"}, command("a.hmap", "counted"));
  for (const long at_call : numbers(calls, 20)) {
    SCOPED_TRACE(at_call);
    std::filesystem::remove(at("a.hmap"));
    const Ran ran = run_with({"disk", "9", at_call}, command("a.hmap", "out"));
    EXPECT_NE(ran.code, 0);
    expect_resumes(whole);
  }
}

TEST_F(MapFaults, AMapOfSeveralRobotsOutlivesBeingKilled) {
  ASSERT_EQ(run_app("hybrid-simulate -c " HYBRID_SOURCE_DIR "/config/simulate_team_demo.ini -o " +
                    at("team.rawlog"))
                .code,
            0);
  const auto of_two = [this](const std::string& map, const std::string& out) {
    return "hybrid-replay --no-pictures --set plugins.classes=BearingRangeKnownIds --rawlog " +
           at("team_anna.rawlog") + " --rawlog " + at("team_bert.rawlog") + " --map " + at(map) +
           " -o " + at(out);
  };
  const auto content_of_two = [this](const std::string& map) {
    const Ran ran = run_app("hybrid-map export --no-pictures -o " + at("export") + " " + at(map));
    EXPECT_EQ(ran.code, 0) << ran.text;
    return read("export/landmarks.csv") + read("export/trajectory_1_team_anna.tum") +
           read("export/trajectory_1_team_bert.tum");
  };
  ASSERT_EQ(run_app(of_two("whole.hmap", "out")).code, 0);
  const std::string whole = content_of_two("whole.hmap");
  const long calls = count({"disk", "9"}, of_two("a.hmap", "counted"));
  for (const long at_call : {calls / 3, calls / 2, 4 * calls / 5}) {
    SCOPED_TRACE(at_call);
    std::filesystem::remove(at("a.hmap"));
    EXPECT_NE(run_with({"disk", "9", at_call}, of_two("a.hmap", "out")).code, 0);
    const auto session = info_of("a.hmap")["sessions"][0];
    ASSERT_FALSE(session["complete"]);
    ASSERT_EQ(session["robots"].size(), 2u);
    const Ran ran = run_app(of_two("a.hmap", "again") + " --resume");
    EXPECT_EQ(ran.code, 0) << ran.text;
    EXPECT_EQ(content_of_two("a.hmap"), whole);
  }
}

TEST_F(MapFaults, AMapOutlivesAFullDisk) {
  ASSERT_EQ(run_app(command("whole.hmap", "out")).code, 0);
  const std::string whole = content("whole.hmap");
  const long calls = count({"space", "on"}, command("a.hmap", "counted"));
  for (const long at_call : numbers(calls, 12)) {
    SCOPED_TRACE(at_call);
    std::filesystem::remove(at("a.hmap"));
    const Ran ran = run_with({"space", "on", at_call}, command("a.hmap", "out"));
    EXPECT_EQ(ran.code, 1) << ran.text;
    EXPECT_EQ(ran.text.rfind("hybrid-replay: ", 0), 0u) << ran.text;
    EXPECT_NE(ran.text.find(folder.string()), std::string::npos) << ran.text;
    expect_resumes(whole);
  }
}

TEST_F(MapFaults, OutAndMapAppearTogetherOrNotAtAll) {
  const long calls = count({"space", "on"}, command("a.hmap", "counted"));
  for (long at_call = calls - 30; at_call <= calls; ++at_call) {
    SCOPED_TRACE(at_call);
    std::filesystem::remove(at("a.hmap"));
    std::filesystem::remove_all(at("out"));
    run_with({"space", "on", at_call}, command("a.hmap", "out"));
    const bool out = std::filesystem::exists(at("out/trajectory.tum"));
    EXPECT_EQ(info_of("a.hmap")["sessions"][0]["complete"], out);
  }
}

}  // namespace
}  // namespace hybrid
