// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A replay that makes a map is killed, or its disk is full, at calls that change the disk.

#include <nlohmann/json.hpp>

#include "mrpt_plugins/map_file/map_file.h"
#include "tests/apps/scan_log.h"
#include "tests/faults/injection.h"
#include "tests/support/cloud_worlds.h"

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

/// A map of laser scans, of which the local maps are a part.
class ScanMapFaults : public MapFaults {
 protected:
  /// Replays with a fault until nothing is left to do, and returns whether a session was resumed.
  bool goes_on_after(const std::string& command, long at_call) const {
    EXPECT_NE(run_with({"disk", "9", at_call}, command).code, 0);
    const auto sessions = info_of("a.hmap")["sessions"];
    const bool is_open = !sessions.empty() && !sessions.back()["complete"];
    const Ran ran = run_app(command + (is_open ? " --resume" : ""));
    EXPECT_EQ(ran.code, 0) << ran.text;
    return is_open;
  }
  /// A log, and one of a part of the way, later.
  void write_two_logs() const {
    ScanLog first;
    write_scan_log(at("first.rawlog"), first);
    ScanLog second;
    second.way.assign(first.way.begin() + 150, first.way.end() - 150);
    second.time = [](std::size_t i) { return 2e9 + 0.2 * double(i); };
    write_scan_log(at("second.rawlog"), second);
  }
  std::string replay(const std::string& log, const std::string& map, const std::string& out) const {
    return "hybrid-replay --no-pictures " + at(log) + " --map " + at(map) + " -o " + at(out);
  }
  void expect_equal(const std::string& name, const std::string& other) const {
    const MapRecord a = read_map(at(name)), b = read_map(at(other));
    ASSERT_EQ(a.sessions.size(), b.sessions.size());
    ASSERT_EQ(a.local_maps.size(), b.local_maps.size());
    for (std::size_t m = 0; m < a.local_maps.size(); ++m) {
      SCOPED_TRACE(m);
      EXPECT_EQ(a.local_maps[m].session, b.local_maps[m].session);
      EXPECT_EQ(a.local_maps[m].pose, b.local_maps[m].pose);
      EXPECT_EQ(a.local_maps[m].covariance, b.local_maps[m].covariance);
      ASSERT_EQ(a.local_maps[m].surfaces.size(), b.local_maps[m].surfaces.size());
      for (std::size_t s = 0; s < a.local_maps[m].surfaces.size(); ++s) {
        EXPECT_EQ(a.local_maps[m].surfaces[s].position, b.local_maps[m].surfaces[s].position);
      }
      ASSERT_EQ(a.local_maps[m].parent.has_value(), m > 0);  // of the first session, or a later one
      ASSERT_EQ(b.local_maps[m].parent.has_value(), m > 0);
      if (m == 0) continue;
      EXPECT_EQ(a.local_maps[m].parent->covariance, b.local_maps[m].parent->covariance);
    }
    for (std::size_t s = 0; s < a.sessions.size(); ++s) {
      ASSERT_EQ(a.sessions[s].keyframes.size(), b.sessions[s].keyframes.size());
      for (std::size_t k = 0; k < a.sessions[s].keyframes.size(); ++k) {
        EXPECT_TRUE(a.sessions[s].keyframes[k].T_map_robot.matrix() ==
                    b.sessions[s].keyframes[k].T_map_robot.matrix());
      }
    }
  }
};

TEST_F(ScanMapFaults, BuildingAndExtendingByLaserScansOutliveBeingKilled) {
  write_two_logs();
  ASSERT_EQ(run_app(replay("first.rawlog", "first.hmap", "first")).code, 0);
  std::filesystem::copy(at("first.hmap"), at("both.hmap"));
  ASSERT_EQ(run_app(replay("second.rawlog", "both.hmap", "both")).code, 0);
  ASSERT_GT(read_map(at("both.hmap")).local_maps.size(),
            read_map(at("first.hmap")).local_maps.size());

  int resumed = 0;
  long calls = count({"disk", "9"}, replay("first.rawlog", "a.hmap", "counted"));
  for (const long at_call : {calls / 3, 2 * calls / 3, calls - 20}) {
    SCOPED_TRACE(at_call);
    std::filesystem::remove(at("a.hmap"));
    resumed += goes_on_after(replay("first.rawlog", "a.hmap", "out"), at_call) ? 1 : 0;
    expect_equal("a.hmap", "first.hmap");
  }
  EXPECT_GE(resumed, 2);

  const auto begin_again = [this] {
    std::filesystem::copy_file(at("first.hmap"), at("a.hmap"),
                               std::filesystem::copy_options::overwrite_existing);
  };
  begin_again();
  calls = count({"disk", "9"}, replay("second.rawlog", "a.hmap", "counted"));
  resumed = 0;
  for (const long at_call : {calls / 3, 2 * calls / 3, calls - 20}) {
    SCOPED_TRACE(at_call);
    begin_again();
    resumed += goes_on_after(replay("second.rawlog", "a.hmap", "out"), at_call) ? 1 : 0;
    expect_equal("a.hmap", "both.hmap");
  }
  EXPECT_GE(resumed, 2);
}

/// Path, closures, surfaces and map file are those of an undisturbed run, byte by byte.
TEST_F(MapFaults, AMapOfCloudsOutlivesBeingKilled) {
  std::filesystem::create_directories(at("in"));
  std::mt19937 random(4);
  int count_of_clouds = 0;
  for (const SE3& pose : testing::way_around_hall(1)) {
    std::string bytes;
    for (const Eigen::Vector3f& p : testing::cloud_at(testing::cluttered_hall(), pose, random)) {
      const float values[4] = {p.x(), p.y(), p.z(), 0};
      bytes.append(reinterpret_cast<const char*>(values), sizeof values);
    }
    write("in/" + std::to_string(count_of_clouds++) + ".bin", bytes);
  }
  ASSERT_EQ(run_app("hybrid-import clouds " + at("in") + " -o " + at("in.rawlog")).code, 0);
  const auto of_clouds = [this](const std::string& map, const std::string& out) {
    return "hybrid-replay --no-pictures " + at("in.rawlog") +
           " --set PointClouds.map_length=1 --map " + at(map) + " -o " + at(out);
  };
  const auto content_of_clouds = [this](const std::string& map, const std::string& out) {
    const Ran ran = run_app("hybrid-map export --no-pictures -o " + at("export") + " " + at(map));
    EXPECT_EQ(ran.code, 0) << ran.text;
    return read(out + "/trajectory.tum") + read(out + "/cloud_loops.csv") +
           read(out + "/cloud.ply") + read("export/trajectory_1.tum") + read("export/cloud.ply");
  };
  ASSERT_EQ(run_app(of_clouds("whole.hmap", "whole")).code, 0);
  EXPECT_NE(read("whole/cloud_loops.csv").find("accepted"), std::string::npos);
  const std::string whole = content_of_clouds("whole.hmap", "whole");
  const long calls = count({"disk", "9"}, of_clouds("a.hmap", "counted"));
  int resumed = 0;
  for (const long at_call : {calls / 3, 2 * calls / 3}) {
    SCOPED_TRACE(at_call);
    std::filesystem::remove(at("a.hmap"));
    EXPECT_NE(run_with({"disk", "9", at_call}, of_clouds("a.hmap", "again")).code, 0);
    const auto session = info_of("a.hmap")["sessions"][0];
    if (!session["complete"] && session["keyframes"] > 0) ++resumed;
    const Ran ran = run_app(of_clouds("a.hmap", "again") + " --resume");
    EXPECT_EQ(ran.code, 0) << ran.text;
    EXPECT_TRUE(content_of_clouds("a.hmap", "again") == whole);
  }
  EXPECT_GE(resumed, 1);
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
    if (ran.text.find("the map holds what it did") != std::string::npos) {
      // Where there was no room for the tables, it holds nothing.
      const bool is_map = run_app("hybrid-map info " + at("a.hmap")).code == 0;
      const auto sessions = is_map ? info_of("a.hmap")["sessions"] : nlohmann::json::array();
      const bool told = ran.text.find("session 1 is interrupted: --resume") != std::string::npos;
      EXPECT_EQ(told, !sessions.empty()) << ran.text;
    }
    expect_resumes(whole);
  }
}

TEST_F(ScanMapFaults, AMapThatIsExtendedOutlivesAFullDisk) {
  write_two_logs();
  const std::string extend = replay("second.rawlog", "a.hmap", "out");
  ASSERT_EQ(run_app(replay("first.rawlog", "first.hmap", "first")).code, 0);
  const auto begin_again = [this] {
    std::filesystem::copy_file(at("first.hmap"), at("a.hmap"),
                               std::filesystem::copy_options::overwrite_existing);
  };
  std::filesystem::copy_file(at("first.hmap"), at("both.hmap"));
  ASSERT_EQ(run_app(replay("second.rawlog", "both.hmap", "both")).code, 0);
  begin_again();
  const long calls = count({"space", "on"}, extend);
  for (const long at_call : numbers(calls, 6)) {
    SCOPED_TRACE(at_call);
    begin_again();
    const Ran ran = run_with({"space", "on", at_call}, extend);
    EXPECT_EQ(ran.code, 1) << ran.text;
    const auto sessions = info_of("a.hmap")["sessions"];
    const bool is_open = !sessions.back()["complete"];
    ASSERT_EQ(sessions.size(), is_open ? 2U : 1U);
    if (ran.text.find("the map holds what it did") != std::string::npos) {
      const bool told = ran.text.find("session 2 is interrupted: --resume") != std::string::npos;
      EXPECT_EQ(told, is_open) << ran.text;
    }
    EXPECT_EQ(read_map(at("a.hmap")).local_maps.size(),
              read_map(at("first.hmap")).local_maps.size());
    EXPECT_EQ(run_app(extend + (is_open ? " --resume" : "")).code, 0);
    expect_equal("a.hmap", "both.hmap");
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
