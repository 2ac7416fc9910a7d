// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "tests/apps/replay_runner.h"

namespace hybrid {
namespace {

using AutoPlugins = ReplayTest;
using Names = std::vector<std::string>;

const std::string kMrptLogs = "/usr/share/mrpt/datasets/";
const std::string kOwnLogs = HYBRID_SOURCE_DIR "/rawlogs/";

TEST_F(AutoPlugins, AnyLogIsMappedWithoutAnIni) {
  const std::pair<std::string, const char*> logs[] = {
      {kMrptLogs + "kf-slam_demo.rawlog", "BearingRangeKnownIds"},
      {kMrptLogs + "kf-slam_6D_demo_DA.rawlog", "BearingRangeAssociation"},
      {kMrptLogs + "RO-SLAM_demo.rawlog", "BeaconRanges"},
      {kMrptLogs + "uwb_ro-localization_demo.rawlog", "BeaconRanges"},
      {kOwnLogs + "classed_demo.rawlog", "ClassedBearingRangeKnownIds"},
      {kOwnLogs + "slip_demo.rawlog", "BearingRangeKnownIds"}};
  for (const auto& [log, plugin] : logs) {
    nlohmann::json summary = summary_of(log);
    EXPECT_EQ(summary["status"], "ok") << log;
    EXPECT_EQ(summary["chosen_plugins"][0], plugin) << log;
    EXPECT_GE(summary["landmarks"], 2) << log;
    EXPECT_FALSE(summary["truth"].contains("trajectory")) << log;
  }
}

TEST_F(AutoPlugins, TheChoiceMapsAsTheNameDoes) {
  const std::string with_ini = "-c " + config("ro_slam_demo.ini");
  const auto named = summary_of(with_ini);
  const auto chosen = summary_of(with_ini + " --set plugins.classes=auto");
  EXPECT_EQ(chosen["objective"], named["objective"]);
  EXPECT_FALSE(named.contains("chosen_plugins"));
}

TEST_F(AutoPlugins, HiddenIdsLeadToAssociation) {
  const auto summary =
      summary_of("--rawlog " + kOwnLogs + "classed_demo.rawlog --set sensor.ids=none");
  EXPECT_EQ(summary["chosen_plugins"], Names{"BearingRangeAssociation"});
}

TEST_F(AutoPlugins, BeaconsAndLaserScansAreMappedTogether) {
  const Ran ran =
      run_replay(kMrptLogs + "uwb_ro-localization_demo.rawlog --no-pictures -o " + at("out"));
  EXPECT_EQ(ran.code, 0);
  EXPECT_NE(ran.text.find("plugins chosen by what the log holds: BeaconRanges, LaserScans\n"),
            std::string::npos)
      << ran.text;
  const auto observations =
      nlohmann::json::parse(read_file(at("out/summary.json")))["observations"];
  EXPECT_EQ(observations["CObservation2DRangeScan"]["used_by"], Names{"LaserScans"});
  EXPECT_EQ(observations["CObservationBeaconRanges"]["used_by"], Names{"BeaconRanges"});
}

TEST_F(AutoPlugins, ALogThatNoChosenPluginTakesIsEmptyAndSaysWhy) {
  const auto summary =
      summary_of(kMrptLogs + "localization_demo.rawlog --set plugins.classes=BeaconRanges", 2);
  EXPECT_EQ(summary["status"], "empty");
  const std::string message = summary["message"];
  EXPECT_NE(message.find("uses what the log holds, 37 CObservation2DRangeScan for LaserScans; "),
            std::string::npos)
      << message;
}

TEST_F(AutoPlugins, AWrongPluginIsToldWhichOneFits) {
  const std::string arguments = "-c " + config("ro_slam_demo.ini") +
                                " --set plugins.classes=BearingRangeKnownIds --truth-path " +
                                write("far.tum", "0 0 0 0 0 0 0 1\n");
  const Ran ran = run_replay(arguments + " --no-pictures -o " + at("out"));
  EXPECT_EQ(ran.code, 1) << ran.text;  // a truth of another time
  const auto summary = summary_of(
      "-c " + config("ro_slam_demo.ini") + " --set plugins.classes=BearingRangeKnownIds", 2);
  EXPECT_EQ(summary["status"], "empty");
  const std::string message = summary["message"];
  EXPECT_NE(message.find("100 CObservationBeaconRanges for BeaconRanges; [plugins] classes = auto"),
            std::string::npos)
      << message;
  for (const auto& file : std::filesystem::directory_iterator(folder / "out")) {
    const std::string text = read_file(file.path());
    for (const char* bad : {"-nan", "nan,", ",nan", ":nan", "inf,"}) {
      EXPECT_EQ(text.find(bad), std::string::npos) << file.path();
    }
  }
}

TEST_F(AutoPlugins, APluginOfTheUserGoesFirst) {
  const auto summary =
      summary_of("-p " HYBRID_EXAMPLE_PLUGIN " " + kMrptLogs + "kf-slam_demo.rawlog");
  EXPECT_EQ(summary["chosen_plugins"], Names{"RobustBearingRange"});
  const auto scans =
      summary_of(kMrptLogs + "uwb_ro-localization_demo.rawlog -p " HYBRID_EXAMPLE_PLUGIN);
  EXPECT_EQ(scans["chosen_plugins"], (Names{"BeaconRanges", "ScanCounter", "WallCompass"}));
  EXPECT_GT(scans["plugins"]["rays"], 0);
}

TEST_F(AutoPlugins, WithoutALogTheHelpIsNamed) {
  const Ran ran = run_replay("-o " + at("out"));
  EXPECT_EQ(ran.code, 1);
  EXPECT_NE(ran.text.find("--help"), std::string::npos) << ran.text;
}

}  // namespace
}  // namespace hybrid
