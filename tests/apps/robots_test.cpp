// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Several robots in one replay.
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "tests/apps/robots_runner.h"

namespace hybrid {
namespace {

TEST_F(Robots, AreFoundByTheIdsOfTheirLandmarks) {
  const auto summary = summary_of("-c " + team("BearingRangeKnownIds"));
  EXPECT_EQ(summary.at("status"), "ok");
  ASSERT_EQ(summary.at("robots").size(), 3U);
  EXPECT_EQ(summary["robots"][2].at("name"), "carl");
  for (int i = 0; i < 3; ++i) EXPECT_LT(error(summary, i), 0.15) << i;
  EXPECT_EQ(summary.at("truth").at("landmarks").at("spurious"), 0);
  EXPECT_GT(summary.at("plugins").at("robot_sightings"), 20);
}

TEST_F(Robots, AreFoundByTheArrangementOfTheirLandmarks) {
  const auto summary =
      summary_of("-c " + team("BearingRangeAssociation", "[sensor]\nids = none\n"));
  EXPECT_EQ(summary.at("status"), "ok");
  for (int i = 0; i < 3; ++i) EXPECT_LT(error(summary, i), 0.2) << i;
  EXPECT_GT(summary.at("plugins").at("robot_sightings"), 20);  // only ids of landmarks are hidden
}

TEST_F(Robots, AreFoundByWhereTheySeeEachOther) {
  // Bert is too short of sight for landmarks, and cannot be told from a stone by himself.
  const std::string two = "[plugins]\nclasses = BearingRangeKnownIds\n" + robot("anna", -101) +
                          robot("bert", -102, "sensor.max_range = 0.6\n");
  const auto summary = summary_of("-c " + write("two.ini", two));
  EXPECT_EQ(summary.at("status"), "ok");
  ASSERT_EQ(summary.at("robots").size(), 2U);
  for (int i = 0; i < 2; ++i) EXPECT_LT(error(summary, i), 0.5) << i;
}

TEST_F(Robots, HaveAFolderEach) {
  const Ran ran = run_replay("-c " + team("BearingRangeKnownIds") + " -o " + at("out"));
  ASSERT_EQ(ran.code, 0) << ran.text;
  for (const char* name : {"anna", "bert", "carl"}) {
    for (const char* file :
         {"trajectory.tum", "trajectory_dead_reckoning.tum", "trajectory_truth.tum", "error.png"}) {
      EXPECT_TRUE(std::filesystem::exists(folder / "out" / name / file)) << name << file;
    }
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "out" / "trajectory.tum"));
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "map.png"));
}

TEST_F(Robots, StreamedLinesAreAloneOnStandardOutput) {
  const Ran ran =
      run_shell(HYBRID_BINARY_DIR "/bin/hybrid-replay -c " + team("BearingRangeKnownIds") +
                " --stream --no-pictures -o " + at("out") + " 2>" + at("said.txt"));
  ASSERT_EQ(ran.code, 0);
  std::istringstream lines(ran.text);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_TRUE(nlohmann::json::accept(line)) << line;
  }
  EXPECT_NE(read("said.txt").find(" m (anna 0."), std::string::npos);
}

TEST_F(Robots, ThoseWithATruePathAreNamedInBrackets) {
  const std::string ini =
      write("two.ini",
            "[plugins]\nclasses = BearingRangeKnownIds\n[robot.anna]\nid = -101\n"
            "rawlog = team_anna.rawlog\n" +
                robot("bert", -102));
  const Ran ran = run_replay("-c " + ini + " -o " + at("out"));
  EXPECT_NE(ran.text.find(" keyframes have a true pose) (bert 0."), std::string::npos) << ran.text;
}

TEST_F(Robots, ALogAloneIsASingleRobotWhateverItIsCalled) {
  const auto alone = summary_of(at("team_anna.rawlog"));
  EXPECT_FALSE(alone.contains("robots"));
  const std::string before = read("out/trajectory.tum");
  const auto named = summary_of("--rawlog anna=" + at("team_anna.rawlog"));
  EXPECT_EQ(read("out/anna/trajectory.tum"), before);
}

TEST_F(Robots, SeveralLogsAreNamedAfterTheirFiles) {
  const auto summary =
      summary_of("--rawlog " + at("team_anna.rawlog") + " --rawlog " + at("team_bert.rawlog"));
  ASSERT_EQ(summary.at("robots").size(), 2U);
  EXPECT_EQ(summary["robots"][1].at("name"), "team_bert");
}

TEST_F(Robots, AStartThatIsGivenIsNotLookedFor) {
  // Two robots that see nothing in common but each other.
  const std::string ini =
      write("two.ini", "[plugins]\nclasses = BearingRangeKnownIds\n" + robot("anna", -101) +
                           robot("bert", -102, "start = 8 4 90\nsensor.max_range = 0.6\n"));
  const auto summary = summary_of("-c " + ini);
  EXPECT_EQ(summary.at("robots").size(), 2U);
}

TEST_F(Robots, AreFoundInTheFrameInWhichTheFirstStarts) {
  const std::string ini =
      write("two.ini", "[plugins]\nclasses = BearingRangeKnownIds\n" +
                           robot("anna", -101, "start = 30 -20 140\n") + robot("bert", -102));
  const auto summary = summary_of("-c " + ini);
  for (int i = 0; i < 2; ++i) EXPECT_LT(error(summary, i), 0.15) << i;
}

TEST_F(Robots, OneWithoutACommonPlaceIsLeftOut) {
  const std::string ini =
      write("two.ini", "[plugins]\nclasses = BearingRangeKnownIds\n[robots]\nsightings = no\n" +
                           robot("anna", -101) + robot("bert", -102, "sensor.max_range = 0.6\n"));
  const auto summary = summary_of("-c " + ini, 2);
  EXPECT_EQ(summary.at("status"), "partial");
  EXPECT_NE(summary.at("message").get<std::string>().find("bert"), std::string::npos);
}

TEST_F(Robots, ClocksAreMadeOne) {
  const auto ahead =
      summary_of("-c " + team("BearingRangeKnownIds") + " --set robot.bert.clock_offset=0.25");
  std::istringstream lines(read("out/bert/trajectory.tum"));
  std::string line;
  std::getline(lines, line);
  std::getline(lines, line);
  EXPECT_EQ(line.substr(0, line.find(' ')), "1767225600.25") << line;
}

TEST_F(Robots, WhatTheyCannotHaveIsRefusedByName) {
  const auto refused = [&](const std::string& text, const std::string& part) {
    const std::string ini = write("bad.ini", robot("anna", -101) + text);
    expect_failure("-c " + ini, part);
  };
  refused("tile = x\n", "bad.ini:5:1: [robot.anna] tile is nothing that a robot has of its own");
  refused("sensor.max_rang = 5\n", "[robot.anna] sensor.max_rang is no key of [sensor]");
  refused("sensor.max_range = far\n", "max_range = 'far' is not valid");
  refused("solver.mode = batch\n", "[robot.anna] solver.mode is nothing that a robot has");
  refused("plugins = Foo\n", "[robot.anna] plugins names Foo");
  refused("[robot.bert]\nid = -101\nrawlog = team_bert.rawlog\n", "two robots have the id -101");
  refused("[robot.a/b]\nrawlog = team_bert.rawlog\n", "the name of a robot is made of letters");
  refused("[robot.bert]\nid = 5\n", "[robot.bert] rawlog names no log");
  refused("[log]\nrawlog = team_bert.rawlog\n", "is one log, but there are sections [robot.NAME]");
  expect_failure("-c " + team("BearingRangeKnownIds", "[solver]\nmode = filter\n"),
                 "several robots need [solver] mode = bounded, incremental or batch, not filter");
}

TEST_F(Robots, ThePrintedConfigurationReadsBack) {
  const std::string ini = team("BearingRangeKnownIds");
  const Ran printed = run_replay("-c " + ini + " --print-config");
  ASSERT_EQ(printed.code, 0) << printed.text;
  std::filesystem::create_directory(folder / "below");
  const std::string again = write("below/again.ini", printed.text);
  summary_of("-c " + ini);
  const std::string before = read("out/carl/trajectory.tum");
  summary_of("-c " + again);
  EXPECT_EQ(read("out/carl/trajectory.tum"), before);
}

}  // namespace
}  // namespace hybrid
