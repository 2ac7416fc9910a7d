// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Several robots and one map file.
#include <array>
#include <cmath>
#include <map>
#include <sstream>

#include "libhybrid/core/infinity.h"
#include "mrpt_plugins/map_file/map_file.h"
#include "tests/apps/robots_runner.h"
#include "tests/support/rawlog_edit.h"

namespace hybrid {
namespace {

using Json = nlohmann::json;

constexpr const char* kNames[] = {"anna", "bert", "carl"};

class RobotsInAMap : public Robots {
 protected:
  Json replay(const std::string& arguments, const std::string& out, int code = 0) const {
    const Ran ran =
        run_replay(arguments + " --no-pictures --map " + at("a.hmap") + " -o " + at(out));
    EXPECT_EQ(ran.code, code) << ran.text;
    return Json::parse(read(out + "/summary.json"), nullptr, false);
  }
  Json build(const std::string& out = "out") const {
    return replay("-c " + team("BearingRangeKnownIds"), out);
  }
  Json info(const std::string& map = "a.hmap") const {
    const Ran ran = run_app("hybrid-map info --json " + at(map));
    EXPECT_EQ(ran.code, 0) << ran.text;
    return Json::parse(ran.text, nullptr, false);
  }
  /// Cuts the log of each robot in two, each part more than half: NAME_first and NAME_second.
  /// Skips the test where MRPT's own program cannot do it.
  void cut_in_two() const {
    const std::string why = why_rawlog_edit_cannot();
    if (!why.empty()) GTEST_SKIP() << why;
    for (const char* name : kNames) {
      const std::string log = at(std::string("team_") + name);
      for (const auto& [part, range] : std::map<std::string, std::string>{
               {"first", "--to-index 220"}, {"second", "--from-index 160"}}) {
        const Ran ran = run_shell(
            "rawlog-edit --cut -w -p " HYBRID_BINARY_DIR "/lib/libhybrid_mrpt.so " + range +
            " -i " + log + ".rawlog -o " + at(name + ("_" + part)) + ".rawlog 2>&1");
        ASSERT_EQ(ran.code, 0) << ran.text;
      }
    }
  }
  std::string logs(const std::string& part) const {
    std::string out;
    for (const std::string name : kNames) {
      out += " --rawlog " + name + "=" + at(name + "_" + part + ".rawlog");
    }
    return out + " --set plugins.classes=BearingRangeKnownIds";
  }
  /// Positions by time.
  std::map<std::string, std::array<double, 2>> path(const std::string& file) const {
    std::map<std::string, std::array<double, 2>> out;
    std::istringstream lines(read(file));
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string time;
      std::array<double, 2> p{};
      if (words >> time >> p[0] >> p[1] && time != "#") out[time] = p;
    }
    return out;
  }
  /// The greatest distance of poses of one time; infinite where two paths have few in common.
  double distance(const std::string& a, const std::string& b) const {
    const auto p = path(a), q = path(b);
    double worst = 0;
    int common = 0;
    for (const auto& [time, at] : p) {
      const auto other = q.find(time);
      if (other == q.end()) continue;
      ++common;
      worst = std::max(worst, std::hypot(at[0] - other->second[0], at[1] - other->second[1]));
    }
    return common < 10 ? kInfinity : worst;
  }
};

TEST_F(RobotsInAMap, AreToldAndExportedEach) {
  const Json summary = build();
  EXPECT_FALSE(summary.contains("localized_at"));
  const Json session = info().at("sessions").at(0);
  ASSERT_EQ(session.at("robots").size(), 3U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(session["robots"][i].at("name"), kNames[i]);
    EXPECT_EQ(session["robots"][i].at("keyframes"), summary["robots"][i].at("keyframes"));
  }
  EXPECT_EQ(session.at("keyframes"), summary.at("keyframes"));
  const Ran told = run_app("hybrid-map info " + at("a.hmap"));
  EXPECT_NE(told.text.find("(anna "), std::string::npos) << told.text;
  EXPECT_EQ(run_app("hybrid-map check " + at("a.hmap")).code, 0);

  ASSERT_EQ(
      run_app("hybrid-map export --origin 36.7 -4.5 90 -o " + at("ex") + " " + at("a.hmap")).code,
      0);
  for (const std::string name : kNames) {
    EXPECT_LT(distance("ex/trajectory_1_" + name + ".tum", "out/" + name + "/trajectory.tum"),
              1e-9);
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "ex" / "trajectory_1.tum"));
  std::vector<std::string> lines;
  const Json globe = Json::parse(read("ex/map.geojson"));
  for (const Json& feature : globe.at("features")) {
    if (feature["geometry"]["type"] == "LineString")
      lines.push_back(feature["properties"]["robot"]);
  }
  EXPECT_EQ(lines, std::vector<std::string>(std::begin(kNames), std::end(kNames)));
}

TEST_F(RobotsInAMap, DoNotChangeForIt) {
  summary_of("-c " + team("BearingRangeKnownIds"));
  const std::string before = read("out/carl/trajectory.tum"), landmarks = read("out/landmarks.csv");
  build();
  EXPECT_EQ(read("out/carl/trajectory.tum"), before);
  EXPECT_EQ(read("out/landmarks.csv"), landmarks);
}

TEST_F(RobotsInAMap, OneIsRemoved) {
  build();
  const auto refused = run_app("hybrid-map prune --robot dora " + at("a.hmap"));
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.text.find("a.hmap: has no robot dora"), std::string::npos) << refused.text;
  const Json before = info();
  ASSERT_EQ(run_app("hybrid-map prune --robot bert " + at("a.hmap")).code, 0);
  const Json after = info();
  EXPECT_EQ(after["sessions"][0]["robots"][1]["keyframes"], 0);
  for (const int other : {0, 2}) {
    EXPECT_EQ(after["sessions"][0]["robots"][other], before["sessions"][0]["robots"][other]);
  }
  EXPECT_EQ(after["landmarks"], before["landmarks"]);
  EXPECT_EQ(run_app("hybrid-map check " + at("a.hmap")).code, 0);
}

TEST_F(RobotsInAMap, FindTheirPlacesInIt) {
  cut_in_two();
  if (IsSkipped()) return;
  replay(logs("first"), "first");
  const std::string map = read("a.hmap");
  const Json summary = replay(logs("second") + " --map-mode localize", "second");
  EXPECT_EQ(read("a.hmap"), map);
  EXPECT_FALSE(summary.contains("localized_at"));
  for (int i = 0; i < 3; ++i) {
    const std::string name = kNames[i];
    ASSERT_TRUE(summary.at("robots").at(i).at("localized_at").is_number()) << name;
    EXPECT_LT(summary["robots"][i]["localized_at"], 40) << name;
    // Poses that both logs have, as the one that made the map has them.
    EXPECT_LT(distance("second/" + name + "/trajectory.tum", "first/" + name + "/trajectory.tum"),
              0.15);
    EXPECT_TRUE(std::filesystem::exists(folder / "second" / name / "trajectory_covariances.csv"));
  }
  EXPECT_EQ(summary["landmarks"], info()["landmarks"]);
}

TEST_F(RobotsInAMap, ContinueIt) {
  cut_in_two();
  if (IsSkipped()) return;
  const int whole = summary_of("-c " + team("BearingRangeKnownIds"))["landmarks"];
  replay(logs("first"), "first");
  const Json summary = replay(logs("second"), "second");
  const Json after = info();
  ASSERT_EQ(after.at("sessions").size(), 2U);
  EXPECT_EQ(after["sessions"][1]["mode"], "extend");
  EXPECT_EQ(after["sessions"][1]["robots"][2]["keyframes"], summary["robots"][2]["keyframes"]);
  EXPECT_EQ(after["landmarks"], whole);
  for (const std::string name : kNames) {
    EXPECT_LT(distance("second/" + name + "/trajectory.tum", "first/" + name + "/trajectory.tum"),
              0.15);
  }
  // One of them alone, with other settings, is a log that the map has.
  const std::string before = read("a.hmap");
  const Ran again = run_replay(at("bert_second.rawlog") + " --no-pictures --map " + at("a.hmap") +
                               " --set plugins.classes=BearingRangeKnownIds -o " + at("again"));
  EXPECT_EQ(again.code, 1);
  EXPECT_NE(again.text.find("session 2 mapped " + at("bert_second.rawlog") + " already"),
            std::string::npos)
      << again.text;
  EXPECT_EQ(read("a.hmap"), before);
}

TEST_F(RobotsInAMap, OneWithoutAPlaceIsLeftOut) {
  // Bert is short of sight in the second log.
  cut_in_two();
  if (IsSkipped()) return;
  replay("--rawlog anna=" + at("anna_first.rawlog") + " --set plugins.classes=BearingRangeKnownIds",
         "first");
  const Json summary =
      replay(logs("second") + " --set robot.bert.sensor.max_range=0.6", "second", 2);
  ASSERT_EQ(summary.at("robots").size(), 2U);
  EXPECT_EQ(summary["robots"][1]["name"], "carl");
  EXPECT_NE(summary["message"].get<std::string>().find("left out bert"), std::string::npos);
  EXPECT_EQ(info()["sessions"][1]["robots"].size(), 2U);
}

TEST_F(RobotsInAMap, AreMappedApartFromAMapThatHasNoneOfThem) {
  const std::string other = write("other.ini", "[simulation]\nseed = 5\n[world]\nlandmarks = 40\n");
  ASSERT_EQ(run_app("hybrid-simulate -c " + other + " -o " + at("other.rawlog")).code, 0);
  const std::string unknown = "[sensor]\nids = none\n";
  replay("-c " + write("alone.ini", unknown + "[plugins]\nclasses = BearingRangeAssociation\n") +
             " --rawlog " + at("other.rawlog"),
         "other");
  const std::string map = read("a.hmap");
  const Json summary = replay("-c " + team("BearingRangeAssociation", unknown), "out", 2);
  EXPECT_EQ(read("a.hmap"), map);
  EXPECT_NE(summary["message"].get<std::string>().find("not found in"), std::string::npos);
  EXPECT_EQ(summary["robots"].size(), 3U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(summary["robots"][i]["localized_at"].is_null());
    EXPECT_LT(error(summary, i), 0.2) << i;
  }
}

TEST_F(RobotsInAMap, GoOnWhereTheyWereInterrupted) {
  build("whole");
  const MapRecord whole = read_map(at("a.hmap"));
  std::filesystem::rename(folder / "a.hmap", folder / "whole.hmap");
  {
    MapFile file(at("a.hmap"));
    ASSERT_EQ(file.begin(whole.sessions.front(), false), 1);
  }
  // The first poses as a run that ends early has them.
  const std::string command = "-c " + team("BearingRangeKnownIds");
  const Json summary = replay(command + " --resume", "resumed");
  EXPECT_EQ(summary["status"], "ok");
  for (const std::string name : kNames) {
    EXPECT_EQ(read("resumed/" + name + "/trajectory.tum"),
              read("whole/" + name + "/trajectory.tum"));
  }
  const MapRecord resumed = read_map(at("a.hmap"));
  ASSERT_EQ(resumed.sessions.size(), 1U);
  EXPECT_TRUE(resumed.sessions.front().complete);
  EXPECT_EQ(resumed.sessions.front().robots, whole.sessions.front().robots);
  ASSERT_EQ(resumed.sessions.front().keyframes.size(), whole.sessions.front().keyframes.size());
  for (std::size_t i = 0; i < whole.sessions.front().keyframes.size(); ++i) {
    EXPECT_EQ(resumed.sessions.front().keyframes[i].robot,
              whole.sessions.front().keyframes[i].robot);
  }
}

}  // namespace
}  // namespace hybrid
