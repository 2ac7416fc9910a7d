// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/settings/replay_settings.h"

#include <cmath>

#include "libhybrid/core/error.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

constexpr const char* kKnownIds = "[plugins]\nclasses = BearingRangeKnownIds\n";

class Settings : public ScratchFolder {
 protected:
  Settings() {
    write("a.rawlog", "");
    write("b.rawlog", "");
  }

  /// Settings of an INI beside two logs, which are not read.
  ReplaySettings settings(const std::string& text, ReplayRequest request = {}) {
    request.config = write("a.ini", kKnownIds + text);
    ini = open_config(request);
    return read_settings(*ini, request);
  }

  /// Expects that a part of the message names what is wrong.
  void refused(const std::string& text, const std::string& part,
               const ReplayRequest& request = {}) {
    try {
      settings(text, request);
      ADD_FAILURE() << "no error for:\n" << text;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  }

  std::unique_ptr<IniFile> ini;
};

TEST_F(Settings, WhatIsWrongIsNamedByLineSectionAndKey) {
  const std::string log = "[log]\nrawlog = a.rawlog\n";
  refused("", "names no log, and neither does the command line");
  refused(log + "truth_point = 1 2\n", "a.ini:5:1: [log] truth_point needs three numbers");
  refused("[log]\nrawlog = .\n", "is a folder, not a file");
  refused(log + "[map]\nstart = 1 2\n", "[map] start needs three numbers, or six in space");
  refused(log + "[map]\norigin = 91 0 0\n", "[map] origin needs latitude");
  refused(log + "[map]\nmode = grow\n", "mode");
  refused(log + "[map]\nscans = some\n", "scans");
  refused(log + "[evaluation]\nmatch_radius = 0\n", "match_radius");
  refused(log + "[evaluation]\nmatch_radios = 1\n", "match_radios");
  ReplayRequest request;
  request.settings = {"map.start_sigma_m=far"};
  refused(log, "command line: [map] start_sigma_m", request);
}

TEST_F(Settings, ALogFromStandardInputIsNotReadAhead) {
  ReplayRequest request;
  request.rawlog = "-";
  refused("", "give [map] dimension, 2 or 3; auto would read ahead", request);
  request.frames = 3;
  refused("[map]\ndimension = 2\n", "--frames needs a file", request);
  request.frames = 0;
  request.resume = true;
  refused("[map]\ndimension = 2\n", "--resume needs a file", request);
  request.resume = false;
  EXPECT_EQ(settings("[map]\ndimension = 2\n", request).robots.front().rawlog, "-");
}

TEST_F(Settings, TheCommandLineGoesFirst) {
  const std::string text =
      "[log]\nrawlog = a.rawlog\ntruth_path = a.tum\ntitle = Yard\n[map]\nfile = a.hmap\n";
  ReplayRequest request;
  ReplaySettings read = settings(text, request);
  EXPECT_EQ(read.title, "Yard");
  EXPECT_EQ(read.robots.front().truth_path, at("a.tum"));
  EXPECT_EQ(read.map.file, at("a.hmap"));
  EXPECT_EQ(read.map.mode, "auto");
  EXPECT_TRUE(ini->warnings().empty());
  request.map = "b.hmap";
  request.map_mode = "localize";
  request.rawlog = at("b.rawlog");
  read = settings(text, request);
  EXPECT_EQ(read.map.file, "b.hmap");
  EXPECT_TRUE(read.map.localizes());
  // What the INI says is true is not true of another log.
  EXPECT_EQ(read.robots.front().truth_path, "");
  EXPECT_EQ(read.title, "b");
  ASSERT_EQ(ini->warnings().size(), 1U);
  EXPECT_NE(ini->warnings().front().find("truth_path are left out"), std::string::npos);
  request.truth_path = at("b.tum");
  EXPECT_EQ(settings(text, request).robots.front().truth_path, at("b.tum"));
}

TEST_F(Settings, RobotsHaveValuesOfTheirOwn) {
  const ReplaySettings read = settings(
      "[reader]\nclock_offset = 1\n[robot.anna]\nid = 7\nrawlog = a.rawlog\nclock_offset = 2\n"
      "[robot.bert]\nrawlog = b.rawlog\nplugins = BearingRangeKnownIds\nstart = 1 2 90\n");
  ASSERT_EQ(read.robots.size(), 2U);
  EXPECT_EQ(read.title, "robots anna, bert");
  const RobotSettings &anna = read.robots[0], &bert = read.robots[1];
  EXPECT_EQ(anna.source.reader.clock_offset, 2);
  EXPECT_EQ(bert.source.reader.clock_offset, 1);
  EXPECT_EQ(anna.options.id, 7);
  EXPECT_EQ(bert.source.detections.robots.count(7), 1U);  // which are detections of a robot
  EXPECT_EQ(bert.options.plugins, std::vector<bool>{true});
  EXPECT_TRUE(anna.start.pose.empty());
  ASSERT_EQ(bert.start.pose.size(), 3U);
  EXPECT_NEAR(bert.start.pose[2], M_PI / 2, 1e-15);
}

TEST_F(Settings, AThresholdOfKeyframesLeavesTheOthersAsTheyAre) {
  const auto keyframes = [&](const std::string& keys, const std::string& plugin) {
    ReplayRequest request;
    request.settings = {"plugins.classes=" + plugin, "map.dimension=2"};
    const ReplaySettings read = settings("[log]\nrawlog = a.rawlog\n[keyframes]\n" + keys, request);
    const KeyframeOptions& k = read.robots.front().source.keyframes;
    return std::vector<double>{k.min_distance, std::round(k.min_angle * 180 / M_PI), k.min_time};
  };
  using Three = std::vector<double>;
  EXPECT_EQ(keyframes("", "LaserScans"), (Three{0.5, 20, 0}));
  EXPECT_EQ(keyframes("min_distance = 2\n", "LaserScans"), (Three{2, 20, 0}));
  EXPECT_EQ(keyframes("min_angle_deg = 5\n", "LaserScans"), (Three{0.5, 5, 0}));
  EXPECT_EQ(keyframes("min_time = 3\n", "LaserScans"), (Three{0, 0, 3}));
  EXPECT_EQ(keyframes("min_distance = 0\n", "LaserScans"), (Three{0, 20, 0}));
  EXPECT_EQ(keyframes("min_distance = 0\nmin_angle_deg = 0\n", "LaserScans"), (Three{0, 0, 0}));
  EXPECT_EQ(keyframes("min_distance = 2\n", "BearingRangeKnownIds"), (Three{2, 0, 0}));
}

TEST_F(Settings, PluginsThatWereChosenAreNotChosenAgain) {
  ReplaySettings chosen;
  EXPECT_TRUE(with_chosen_plugins({}, chosen).settings.empty());
  chosen.chosen = {"A", "B"};
  EXPECT_EQ(with_chosen_plugins({}, chosen).settings,
            std::vector<std::string>{"plugins.classes=A B"});
  chosen.robots.resize(1);
  chosen.robots[0].source.correction.hides_ids = true;
  EXPECT_EQ(with_chosen_plugins({}, chosen).settings.back(), "sensor.ids=none");
}

TEST(GivenStart, HasItsSigmasInThePlaneAndInSpace) {
  StartOptions options;
  EXPECT_FALSE(given_start(options, false));
  options = {{1, 2, M_PI / 2}, 0.5, 0.1};
  const auto plane = given_start(options, false);
  ASSERT_TRUE(plane);
  EXPECT_NEAR((plane->T_map_robot * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 0)).norm(), 0,
              1e-15);
  EXPECT_TRUE(plane->covariance.diagonal().isApprox(Eigen::Vector3d(0.25, 0.25, 0.01)));
  const auto space = given_start(options, true);
  ASSERT_EQ(space->covariance.rows(), 6);
  EXPECT_EQ(space->covariance(2, 2), 0.25);
  EXPECT_NEAR(space->covariance(3, 3), 0.01, 1e-15);
}

}  // namespace
}  // namespace hybrid
