// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <sqlite3.h>

#include "mrpt_plugins/map_file/map_file.h"
#include "tests/apps/map_runner.h"

namespace hybrid {
namespace {

TEST_F(MapTest, ALogMakesAMapThatSaysWhatItHolds) {
  ASSERT_EQ(run_replay(replay_of("", "a.hmap", "out")).code, 0);
  const auto info = info_of("a.hmap");
  EXPECT_EQ(info["dimension"], 2);
  EXPECT_EQ(info["landmarks"], summary_in("out")["landmarks"]);
  ASSERT_EQ(info["sessions"].size(), 1u);
  EXPECT_EQ(info["sessions"][0]["mode"], "build");
  EXPECT_EQ(info["sessions"][0]["keyframes"], 250);
  EXPECT_EQ(info["sessions"][0]["complete"], true);
  EXPECT_EQ(info["sessions"][0]["inputs"][1]["sha256"], summary_in("out")["inputs"][1]["sha256"]);
  EXPECT_EQ(run_app("hybrid-map check " + at("a.hmap")).code, 0);
}

TEST_F(MapTest, AMapDoesNotChangeWhatALogGives) {
  ASSERT_EQ(run_replay(replay_of("", "", "plain")).code, 0);
  ASSERT_EQ(run_replay(replay_of("", "a.hmap", "out")).code, 0);
  EXPECT_EQ(read("plain/trajectory.tum"), read("out/trajectory.tum"));
  EXPECT_EQ(read("plain/landmarks.csv"), read("out/landmarks.csv"));
  EXPECT_FALSE(summary_in("plain").contains("localized_at"));
}

TEST_F(MapTest, ARobotFindsItsPlaceWithoutAPose) {
  cut_in_two();
  ASSERT_EQ(run_replay(replay_of("", "", "whole")).code, 0);
  ASSERT_EQ(run_replay(replay_of("first.rawlog", "a.hmap", "first")).code, 0);
  const std::string map = read("a.hmap");
  const Ran ran =
      run_replay(replay_of("second.rawlog", "a.hmap", "second") + " --map-mode localize");
  ASSERT_EQ(ran.code, 0);
  EXPECT_EQ(read("a.hmap"), map);
  const auto summary = summary_in("second");
  EXPECT_NE(ran.text.find(", localised at keyframe " + summary["localized_at"].dump()),
            std::string::npos)
      << ran.text;
  EXPECT_NE(ran.text.find(" m, health "), std::string::npos);
  EXPECT_TRUE(summary["localized_at"].is_number());
  EXPECT_LT(summary["localized_at"], 20);
  EXPECT_EQ(summary["landmarks"], info_of("a.hmap")["landmarks"]);
  // The whole is in the frame of the first part; ranges have a sigma of 1 cm.
  EXPECT_LT(distance("second/trajectory.tum", "whole/trajectory.tum", kBeforeSecond), 0.02);
}

TEST_F(MapTest, AMapGrowsWithALog) {
  cut_in_two();
  ASSERT_EQ(run_replay(replay_of("", "", "whole")).code, 0);
  ASSERT_EQ(run_replay(replay_of("first.rawlog", "a.hmap", "first")).code, 0);
  ASSERT_EQ(run_replay(replay_of("second.rawlog", "a.hmap", "second")).code, 0);
  const auto info = info_of("a.hmap");
  ASSERT_EQ(info["sessions"].size(), 2u);
  EXPECT_EQ(info["sessions"][1]["mode"], "extend");
  const int whole = summary_in("whole")["landmarks"], grown = info["landmarks"];
  EXPECT_GT(grown, summary_in("first")["landmarks"]);
  EXPECT_NEAR(grown, whole, 4);
  EXPECT_LT(distance("second/trajectory.tum", "whole/trajectory.tum", kBeforeSecond), 0.02);
  for (const char* const more : {"", " --set sensor.sigma_range=0.02"}) {
    expect_refusal("hybrid-replay " + replay_of("second.rawlog", "a.hmap", "again") + more,
                   "a.hmap", "already: what it measured would count twice");
  }
  // The same log, compressed otherwise.
  ASSERT_EQ(
      run_shell("gzip -dc < " + at("second.rawlog") + " | gzip -9 > " + at("other.rawlog")).code,
      0);
  ASSERT_NE(read("other.rawlog"), read("second.rawlog"));
  expect_refusal("hybrid-replay " + replay_of("other.rawlog", "a.hmap", "again"), "a.hmap",
                 "already: what it measured would count twice");
}

TEST_F(MapTest, MapsWithALogInCommonAreNotJoined) {
  cut_in_two();
  ASSERT_EQ(run_replay(replay_of("first.rawlog", "a.hmap", "first")).code, 0);
  std::filesystem::copy_file(at("a.hmap"), at("b.hmap"));
  ASSERT_EQ(run_replay(replay_of("second.rawlog", "b.hmap", "second")).code, 0);
  const std::string join = "hybrid-map join " + at("a.hmap") + " " + at("b.hmap");
  const Ran ran = run_app(join + " -o " + at("c.hmap"));
  EXPECT_EQ(ran.code, 1) << ran.text;
  EXPECT_NE(ran.text.find(at("b.hmap") + ": its session 1 mapped the log of session 1"),
            std::string::npos)
      << ran.text;
  EXPECT_NE(ran.text.find("would count twice"), std::string::npos) << ran.text;
  EXPECT_FALSE(std::filesystem::exists(at("c.hmap")));
}

TEST_F(MapTest, ARobotIsNotFoundInAnotherMap) {
  write("other.ini", "[simulation]\nseed = 5\nobservation = plain\n[world]\nlandmarks = 40\n");
  ASSERT_EQ(run_app("hybrid-simulate -c " + at("other.ini") + " -o " + at("other.rawlog")).code, 0);
  ASSERT_EQ(run_replay(replay_of("", "a.hmap", "out")).code, 0);
  const std::string map = read("a.hmap");
  const Ran ran = run_replay(replay_of("other.rawlog", "a.hmap", "other"));
  EXPECT_EQ(ran.code, 2) << ran.text;
  EXPECT_NE(ran.text.find("not found in"), std::string::npos) << ran.text;
  EXPECT_TRUE(summary_in("other")["localized_at"].is_null());
  EXPECT_EQ(read("a.hmap"), map);
}

TEST_F(MapTest, LandmarksThatVanishedLoseTheirExistence) {
  // Landmarks are drawn one after the other, so that the second world is the first without six.
  for (const char* const n : {"20", "14"}) {
    const std::string name = std::string("world") + n;
    write(name + ".ini", std::string("[world]\nlandmarks = ") + n +
                             "\n[path]\nlaps = 2\n[sensor]\nmax_range = 30\n");
    ASSERT_EQ(
        run_app("hybrid-simulate -c " + at(name + ".ini") + " -o " + at(name + ".rawlog")).code, 0);
  }
  write("a.ini",
        "[log]\nrawlog = world20.rawlog\n[sensor]\nids = none\n"
        "[plugins]\nclasses = BearingRangeAssociation\n");
  ASSERT_EQ(run_replay(replay_of("world20.rawlog", "a.hmap", "before")).code, 0);
  EXPECT_EQ(info_of("a.hmap")["vanished"], 0);
  const int before = info_of("a.hmap")["landmarks"];
  ASSERT_EQ(run_replay(replay_of("world14.rawlog", "a.hmap", "after")).code, 0);
  const auto info = info_of("a.hmap");
  EXPECT_EQ(info["vanished"], 6);
  const int after = info["landmarks"];
  EXPECT_NEAR(after, before - 6, 1);
  ASSERT_EQ(run_app("hybrid-map prune --vanished " + at("a.hmap")).code, 0);
  EXPECT_EQ(info_of("a.hmap")["vanished"], 0);
  EXPECT_EQ(info_of("a.hmap")["landmarks"], after);
  EXPECT_EQ(run_app("hybrid-map check " + at("a.hmap")).code, 0);
}

TEST_F(MapTest, AStartMayBeGiven) {
  cut_in_two();
  ASSERT_EQ(run_replay(replay_of("first.rawlog", "a.hmap", "first")).code, 0);
  ASSERT_EQ(run_replay(replay_of("first.rawlog", "a.hmap", "again") +
                       " --map-mode localize --set map.start=0.1,-0.1,1 --set map.start_sigma_m=0.2"
                       " --set map.start_sigma_deg=2")
                .code,
            0);
  EXPECT_EQ(summary_in("again")["localized_at"], 0);
  EXPECT_LT(distance("first/trajectory.tum", "again/trajectory.tum"), 0.02);
}

TEST_F(MapTest, OneProcessWritesAMapAtATime) {
  ASSERT_EQ(run_replay(replay_of("", "a.hmap", "out")).code, 0);
  const MapFile writer(at("a.hmap"));
  expect_refusal("hybrid-replay " + replay_of("", "a.hmap", "out"), "a.hmap",
                 "(process " + std::to_string(getpid()) + ") is writing it");
}

TEST_F(MapTest, RefusesWhatDoesNotFitTheLog) {
  ASSERT_EQ(run_replay(replay_of("", "a.hmap", "out")).code, 0);
  const std::string with = "hybrid-replay --no-pictures -o " + at("new") + " --map " + at("a.hmap");
  expect_refusal(with + " -c " + config("kf_slam_6d_demo.ini") + " --set solver.mode=incremental",
                 "a.hmap", "in the plane");
  expect_refusal(with + " -c " + config("classed_demo.ini") + " --set map.start=0,0,0", "a.hmap",
                 "--set sensor.ids=none");
  const std::string again = "hybrid-replay " + replay_of("", "a.hmap", "new");
  expect_refusal(again + " --map-mode build", "a.hmap", "holds a map already");
  expect_refusal(again + " --resume", "a.hmap", "nothing to resume");
  expect_refusal(again + " --set solver.mode=fixed_lag", "a.hmap", "incremental");
  EXPECT_FALSE(std::filesystem::exists(folder / "new" / "summary.json"));
  std::filesystem::remove_all(folder / "out");
  expect_failure("-c " + at("a.ini") + " --map-mode localize", "need a map file");
  expect_failure("-c " + at("a.ini") + " --map-mode localize --map " + at("b.hmap"), "no such map");
}

TEST_F(MapTest, AMapThatIsNotMadeLeavesNothing) {
  write("empty.hmap", "");
  for (const std::string name : {"empty.hmap", "new.hmap"}) {
    const Ran ran = run_app("hybrid-replay " + replay_of("", name, "new") + " --map-mode extend");
    EXPECT_EQ(ran.code, 1);
    EXPECT_NE(ran.text.find("build it first"), std::string::npos) << ran.text;
  }
  EXPECT_EQ(read("empty.hmap"), "");
  EXPECT_FALSE(std::filesystem::exists(at("new.hmap")));
  ASSERT_EQ(run_replay(replay_of("", "a.hmap", "out")).code, 0);
  cut("first.rawlog", "--to-index 299");
  ASSERT_EQ(run_replay(replay_of("first.rawlog", "b.hmap", "out")).code, 0);
  const std::string join = "hybrid-map join " + at("a.hmap") + " " + at("b.hmap") + " -o ";
  const Ran full = run_app(join + at("c.hmap"), "ulimit -f 4; ");
  EXPECT_EQ(full.code, 1);
  EXPECT_NE(full.text.find("this change is not written"), std::string::npos) << full.text;
  EXPECT_FALSE(std::filesystem::exists(at("c.hmap")));
  EXPECT_FALSE(std::filesystem::exists(at("c.hmap-journal")));
  for (const std::string& unnamed :
       {join, "hybrid-replay " + replay_of("", "", "new") + " --map "}) {
    const Ran ran = run_app(unnamed + "''");
    EXPECT_EQ(ran.code, 1);
    EXPECT_NE(ran.text.find("names no file"), std::string::npos) << ran.text;
  }
}

TEST_F(MapTest, AFileThatIsNoLogIsToldBeforeAMapIsLookedAt) {
  write("noise.rawlog", "neither a log nor anything else");
  expect_failure("-c " + at("a.ini") + " --rawlog " + at("noise.rawlog") +
                     " --map-mode localize --map " + at("none.hmap"),
                 "not a rawlog");
}

TEST_F(MapTest, ALogWithoutIdsIsLocatedInAMapOfIdsAndDoesNotExtendIt) {
  cut_in_two();
  const std::string known = " --set sensor.ids=log --set plugins.classes=BearingRangeKnownIds";
  ASSERT_EQ(run_replay(replay_of("first.rawlog", "a.hmap", "first") + known).code, 0);
  for (const std::string start : {"", " --set map.start=0,0,0"}) {
    expect_refusal("hybrid-replay " + replay_of("second.rawlog", "a.hmap", "new") + start, "a.hmap",
                   "its landmarks have the ids of logs");
  }
  const std::string localize = " --map-mode localize";
  ASSERT_EQ(run_replay(replay_of("second.rawlog", "a.hmap", "with") + known + localize).code, 0);
  ASSERT_EQ(run_replay(replay_of("second.rawlog", "a.hmap", "without") + localize).code, 0);
  EXPECT_LT(distance("with/trajectory.tum", "without/trajectory.tum"), 0.02);
}

TEST_F(MapTest, RefusesFilesThatAreNoMapsOrDamaged) {
  ASSERT_EQ(run_replay(replay_of("", "a.hmap", "out")).code, 0);
  const std::string map = read("a.hmap");
  const auto changed = [&](std::size_t at, const std::string& bytes) {
    std::string out = map;
    return out.replace(at, bytes.size(), bytes);
  };
  const std::map<std::string, std::pair<std::string, std::string>> cases = {
      {"text.hmap",
       {"no database at all, but long enough to be read as one by who does not look", "is no map"}},
      {"foreign.hmap", {changed(68, "\1\2\3\4"), "is no map"}},
      {"later.hmap",
       {changed(63, "\10"), "is a map of format 8, this program reads formats 1 to 7"}},
      {"before.hmap", {changed(63, std::string(1, '\0')), "is a map of format 0"}},
      {"damaged.hmap", {changed(3 * 4096, std::string(4096, '\x55')), "damaged"}},
      {"short.hmap", {map.substr(0, map.size() / 2), "damaged"}},
  };
  for (const auto& [name, content] : cases) {
    write(name, content.first);
    expect_refusal("hybrid-replay " + replay_of("", name, "new"), name, content.second);
    expect_refusal("hybrid-map info " + at(name), name, content.second);
    expect_refusal("hybrid-map prune --vanished " + at(name), name, content.second);
    expect_refusal("hybrid-map join -o " + at("c.hmap") + " " + at("a.hmap") + " " + at(name), name,
                   content.second);
  }
}

/// Runs SQL on a file, not by way of the library.
void run_sql(const std::string& file, const char* sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  char* message = nullptr;
  EXPECT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, &message), SQLITE_OK) << message;
  sqlite3_free(message);
  sqlite3_close(database);
}

int format_of(const std::string& file) {
  return static_cast<unsigned char>(read_file(file)[63]);
}

TEST_F(MapTest, FilesOfTheFirstFormatAreReadAndCarriedOver) {
  cut_in_two();
  ASSERT_EQ(run_replay(replay_of("first.rawlog", "a.hmap", "first")).code, 0);
  const auto before = info_of("a.hmap");
  // What the second format has added.
  run_sql(at("a.hmap"),
          "DROP TABLE landmark_size; DROP TABLE surface; DROP TABLE local_map; DROP TABLE robot; "
          "DROP TABLE local_cloud; DROP TABLE place_parent; ALTER TABLE keyframe DROP COLUMN "
          "robot; PRAGMA user_version = 1");
  const std::string old = read("a.hmap");
  EXPECT_EQ(info_of("a.hmap"), before);
  EXPECT_EQ(run_app("hybrid-map check " + at("a.hmap")).code, 0);
  ASSERT_EQ(run_replay(replay_of("second.rawlog", "a.hmap", "there") + " --map-mode localize").code,
            0);
  EXPECT_EQ(read("a.hmap"), old);
  const MapRecord first = read_map(at("a.hmap"));
  ASSERT_EQ(run_replay(replay_of("second.rawlog", "a.hmap", "second")).code, 0);
  EXPECT_EQ(format_of(at("a.hmap")), 7);
  const MapRecord both = read_map(at("a.hmap"));
  ASSERT_EQ(both.sessions.size(), 2u);
  ASSERT_EQ(both.sessions[0].keyframes.size(), first.sessions[0].keyframes.size());
  EXPECT_TRUE(both.sessions[0].keyframes.back().T_map_robot.isApprox(
      first.sessions[0].keyframes.back().T_map_robot, 1e-12));
}

TEST_F(MapTest, AChangeThatIsRefusedLeavesTheFirstFormat) {
  ASSERT_EQ(run_replay(replay_of("", "a.hmap", "out")).code, 0);
  run_sql(at("a.hmap"),
          "DROP TABLE landmark_size; DROP TABLE surface; DROP TABLE local_map; DROP TABLE robot; "
          "DROP TABLE local_cloud; DROP TABLE place_parent; ALTER TABLE keyframe DROP COLUMN "
          "robot; PRAGMA user_version = 1");
  expect_refusal("hybrid-map prune --session 9 " + at("a.hmap"), "a.hmap", "no session 9");
  EXPECT_EQ(format_of(at("a.hmap")), 1);
  ASSERT_EQ(run_app("hybrid-map prune --session 1 " + at("a.hmap")).code, 0);
  EXPECT_EQ(format_of(at("a.hmap")), 7);
}

TEST_F(MapTest, AKeyframeOfARobotThatIsNotThereIsAFault) {
  ASSERT_EQ(run_replay(replay_of("", "a.hmap", "out")).code, 0);
  run_sql(at("a.hmap"), "UPDATE keyframe SET robot = 1 WHERE number = 7");
  expect_refusal("hybrid-map check " + at("a.hmap"), "a.hmap",
                 "keyframe 7 of session 1 is of a robot 1 that is not there");
}

TEST_F(MapTest, ExportsWhatOthersRead) {
  ASSERT_EQ(run_replay(replay_of("", "a.hmap", "out") + " --set map.origin=36.7,-4.5,90").code, 0);
  ASSERT_EQ(run_app("hybrid-map export --no-pictures -o " + at("ex") + " " + at("a.hmap")).code, 0);
  EXPECT_EQ(read("ex/landmarks.csv"), read("out/landmarks.csv"));
  EXPECT_LT(distance("ex/trajectory_1.tum", "out/trajectory.tum"), 1e-12);
  const auto globe = nlohmann::json::parse(read("ex/map.geojson"));
  EXPECT_EQ(globe["features"].size(), summary_in("out")["landmarks"].get<std::size_t>() + 1);
  // The x axis points north: a metre there is 1/111 km of a degree of latitude.
  const MapRecord map = read_map(at("a.hmap"));
  const auto& first = globe["features"][0]["geometry"]["coordinates"];
  EXPECT_NEAR(first[1].get<double>(), 36.7 + map.landmarks[0].position.x() / 110967, 1e-7);
  EXPECT_NE(read("ex/landmarks.pcd").find("\nPOINTS "), std::string::npos);
}

TEST_F(MapTest, TwoMapsBecomeOne) {
  cut_in_two();
  ASSERT_EQ(run_replay(replay_of("", "", "whole")).code, 0);
  ASSERT_EQ(run_replay(replay_of("first.rawlog", "a.hmap", "first")).code, 0);
  ASSERT_EQ(run_replay(replay_of("second.rawlog", "b.hmap", "second")).code, 0);
  const Ran ran =
      run_app("hybrid-map join " + at("a.hmap") + " " + at("b.hmap") + " -o " + at("c.hmap"));
  ASSERT_EQ(ran.code, 0) << ran.text;
  const auto info = info_of("c.hmap");
  EXPECT_EQ(info["sessions"].size(), 2u);
  EXPECT_NEAR(info["landmarks"].get<int>(), summary_in("whole")["landmarks"].get<int>(), 6);
  ASSERT_EQ(run_app("hybrid-map export --no-pictures -o " + at("ex") + " " + at("c.hmap")).code, 0);
  EXPECT_LT(distance("ex/trajectory_2.tum", "whole/trajectory.tum", kBeforeSecond), 0.05);
  expect_refusal("hybrid-map join " + at("a.hmap") + " " + at("b.hmap") + " -o " + at("c.hmap"),
                 "c.hmap", "holds a map already");
}

TEST_F(MapTest, SessionsAreRemoved) {
  ASSERT_EQ(run_replay(replay_of("", "a.hmap", "out")).code, 0);
  ASSERT_EQ(run_app("hybrid-map prune --session 1 " + at("a.hmap")).code, 0);
  EXPECT_EQ(info_of("a.hmap")["sessions"][0]["keyframes"], 0);
  EXPECT_EQ(info_of("a.hmap")["landmarks"], summary_in("out")["landmarks"]);
  expect_refusal("hybrid-map prune --session 9 " + at("a.hmap"), "a.hmap", "no session 9");
}

}  // namespace
}  // namespace hybrid
