// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Map files that others have made or changed.

#include "mrpt_plugins/map_file/map_file.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <random>

#include "libhybrid/core/error.h"
#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/map_file/export_map.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

/// Runs SQL on a file, not by way of the library.
void run_sql(const std::string& file, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  char* message = nullptr;
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &message), SQLITE_OK) << message;
  sqlite3_free(message);
  sqlite3_close(database);
}

/// Three landmarks of two classes, seen in two sessions, the second of two robots.
MapRecord small_map() {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  MapRecord map;
  map.class_names = {"tree", "pole"};
  map.origin = {36.7, -4.5, 90, 12, true};
  for (int i = 0; i < 3; ++i) {
    MapLandmark l;
    l.id = 10 * i;
    l.session = 1;
    l.position = {normal(random), normal(random), 0};
    l.covariance.topLeftCorner(2, 2) = 0.01 * Eigen::Matrix2d::Identity();
    l.class_probabilities = {0.25, 0.75};
    l.existence = 5;
    l.sightings = 7;
    if (i == 1) l.size = {0.25, 3};
    map.landmarks.push_back(l);
  }
  map.prior = sparsify(0.01 * Eigen::MatrixXd::Identity(6, 6), 2);
  for (int id = 1; id <= 2; ++id) {
    MapSession s;
    s.id = id;
    s.mode = id == 1 ? "build" : "extend";
    s.complete = true;
    s.inputs = {{"a.rawlog", "0123"}};
    if (id == 2) s.robots = {"anna", "bert"};
    for (std::size_t i = 0; i < 50; ++i) {
      MapKeyframe k;
      k.row = i;
      k.time = static_cast<double>(i);
      k.robot = id == 2 ? i % 2 : 0;
      const Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
      k.T_map_robot = Eigen::Translation3d(normal(random), 1, 2) * q.normalized();
      s.keyframes.push_back(k);
    }
    map.sessions.push_back(s);
    MapLocalMap local;
    local.session = id;
    local.pose << normal(random), normal(random), 0.3;
    local.covariance = 0.01 * Eigen::Matrix3d::Identity();
    for (int n = 0; n < 40; ++n) {
      local.surfaces.push_back({{0.1 * n, -2.345}, std::nullopt});
      if (n % 2 == 0) local.surfaces.back().direction = -1.571;
    }
    map.local_maps.insert(map.local_maps.end(), {local, local});
  }
  return map;
}

/// All numbers of a map.
std::vector<double> numbers_of(const MapRecord& map) {
  std::vector<double> out;
  for (const MapLandmark& l : map.landmarks) {
    out.insert(out.end(), l.position.begin(), l.position.end());
    out.insert(out.end(), l.covariance.reshaped().begin(), l.covariance.reshaped().end());
    out.insert(out.end(), l.class_probabilities.begin(), l.class_probabilities.end());
    out.insert(out.end(), {double(l.id), l.existence, double(l.sightings), double(l.session)});
    out.insert(out.end(), {l.size.extent, double(l.size.things)});
  }
  for (const MapLocalMap& local : map.local_maps) {
    out.push_back(local.session);
    out.insert(out.end(), local.pose.begin(), local.pose.end());
    out.insert(out.end(), local.covariance.reshaped().begin(), local.covariance.reshaped().end());
    for (const MapSurface& s : local.surfaces) {
      out.insert(out.end(), {s.position.x(), s.position.y(), s.direction.value_or(9)});
    }
  }
  for (const MapSession& s : map.sessions) {
    for (const MapKeyframe& k : s.keyframes) {
      const Eigen::Matrix4d& T = k.T_map_robot.matrix();
      out.insert(out.end(), T.reshaped().begin(), T.reshaped().end());
      out.insert(out.end(), {double(k.row), k.time, double(k.robot)});
    }
  }
  return out;
}

class MapFileTest : public ScratchFolder {
 protected:
  void SetUp() override { MapFile(at("a.hmap")).replace(small_map()); }
  /// Expects that neither reading nor changing a file begins, for a reason that names it.
  void expect_refused(const std::string& name, const std::string& part) const {
    const auto message_of = [&](const auto& open) -> std::string {
      try {
        open();
      } catch (const Error& e) {
        return e.what();
      }
      return "no error";
    };
    const std::string before = std::filesystem::is_regular_file(at(name)) ? read(name) : "";
    for (const std::string& message : {message_of([&] { read_map(at(name)); }),
                                       message_of([&] { const MapFile file(at(name)); })}) {
      EXPECT_NE(message.find(part), std::string::npos) << message;
      EXPECT_EQ(message.rfind(at(name), 0), 0U) << message;
    }
    EXPECT_TRUE(before.empty() || read(name) == before);
  }
  void expect_refused_after(const std::string& sql, const std::string& part) const {
    SCOPED_TRACE(sql);
    const std::string sound = read("a.hmap");
    run_sql(at("a.hmap"), sql);
    expect_refused("a.hmap", part);
    write("a.hmap", sound);
  }
};

TEST_F(MapFileTest, HoldsWhatWasWritten) {
  const MapRecord map = read_map(at("a.hmap"));
  const std::vector<double> a = numbers_of(small_map()), b = numbers_of(map);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-12);
  EXPECT_EQ(map.origin, small_map().origin);
  EXPECT_TRUE(has_checksum(at("a.hmap")));
}

TEST_F(MapFileTest, HoldsTheTablesOfAMapAndNothingElse) {
  const std::string part = "holds other tables, views or triggers than a map";
  expect_refused_after(
      "PRAGMA legacy_alter_table = 1; ALTER TABLE class RENAME TO class0;"
      "CREATE VIEW class AS WITH RECURSIVE c(number) AS (SELECT 0 UNION ALL SELECT number + 1 FROM "
      "c) SELECT number, 'c' AS name FROM c",
      part);
  expect_refused_after(
      "CREATE TRIGGER t AFTER DELETE ON prior BEGIN INSERT INTO draft WITH RECURSIVE c(n) AS "
      "(SELECT 1 UNION ALL SELECT n + 1 FROM c) SELECT n, 0, 0, 0, 0, 0 FROM c; END",
      part);
  expect_refused_after("CREATE TABLE other (x)", part);
  expect_refused_after("CREATE INDEX i ON landmark (x)", part);
  expect_refused_after("ALTER TABLE draft ADD COLUMN y2 AS (x + 1)", part);
  expect_refused_after("DROP TABLE draft", part);
  expect_refused_after("ALTER TABLE keyframe DROP COLUMN robot", part);
}

TEST_F(MapFileTest, HoldsNoMoreThanAMapMay) {
  expect_refused_after("UPDATE session SET command = hex(zeroblob(9000000)) WHERE id = 1",
                       "a text of more than");
  expect_refused_after(
      "INSERT INTO class WITH RECURSIVE c(n) AS (SELECT 2 UNION ALL SELECT n + 1 FROM c WHERE "
      "n < 20000) SELECT n, n FROM c",
      "'number' of a row of table 'class' is 10000, not from 0 to 9999");
}

TEST_F(MapFileTest, HoldsNumbersThatMakeSense) {
  expect_refused_after("UPDATE landmark SET x = 'abc'", "'x' of a row of table 'landmark' is no");
  expect_refused_after("UPDATE landmark SET y = x'01'", "'y' of a row of table 'landmark' is no");
  expect_refused_after("UPDATE landmark SET x = 9e999", "is not finite");
  expect_refused_after("UPDATE landmark SET existence = -9e999", "is not finite");
  expect_refused_after("UPDATE landmark SET sightings = -5", "is -5, not from 0");
  expect_refused_after("UPDATE landmark SET sightings = 1.5", "is no whole number");
  expect_refused_after("UPDATE landmark SET session = 9", "of a session 9 that is not there");
  expect_refused_after("UPDATE landmark SET id = 1 << 56 WHERE id = 20", "is 72057594037927936");
  expect_refused_after("UPDATE landmark SET id = -1 WHERE id = 0", "is -1, not from 0");
  expect_refused_after(
      "UPDATE landmark SET id = 9999999 WHERE id = 20;"
      "UPDATE landmark_class SET landmark = 9999999 WHERE landmark = 20;"
      "UPDATE prior SET landmark = 9999999 WHERE landmark = 20;"
      "UPDATE prior SET given = 9999999 WHERE given = 20",
      "are numbered up to");
  expect_refused_after("UPDATE keyframe SET time = 9e999", "is not finite");
  expect_refused_after("UPDATE keyframe SET row = -1", "is -1, not from 0");
  expect_refused_after("UPDATE prior SET r11 = 9e999", "is not finite");
  expect_refused_after("UPDATE session SET mode = x'00'", "is no text");
  expect_refused_after("UPDATE map SET value = 1000 WHERE name = 'latitude'", "its latitude");
  expect_refused_after("UPDATE map SET value = 'x' WHERE name = 'latitude'", "is no number");
  expect_refused_after("DELETE FROM map WHERE name = 'latitude'", "a part of an origin");
  expect_refused_after("UPDATE map SET value = 1e300 WHERE name = 'loss'", "its loss is 1e+300");
}

TEST_F(MapFileTest, HoldsLocalMapsOfTheirForm) {
  expect_refused_after("UPDATE surface SET x = 0.5 WHERE number = 3", "is no whole number");
  expect_refused_after("UPDATE surface SET y = 100001 WHERE number = 3", "not from -100000");
  expect_refused_after("UPDATE surface SET direction = 4000 WHERE number = 3", "is 4000, not from");
  expect_refused_after("DELETE FROM surface WHERE number = 3", "lacks surface 3");
  expect_refused_after("UPDATE surface SET map = 7 WHERE map = 1", "local map that is not there");
  expect_refused_after("DELETE FROM local_map WHERE number = 0", "are not of their form");
  expect_refused_after("UPDATE local_map SET session = 9 WHERE session = 2", "session 9");
  expect_refused_after("UPDATE local_map SET x = 9e999", "is not finite");
  expect_refused_after("UPDATE local_map SET aa = 0", "has no covariance");
  expect_refused_after("UPDATE surface SET x = x + 1 WHERE number = 3", "checksum");
}

TEST_F(MapFileTest, HoldsNothingThatAMapCannotBe) {
  const std::string landmark = "UPDATE landmark SET ", local = "UPDATE local_map SET ";
  expect_refused_after(landmark + "x = 1e300 WHERE id = 0", "landmark 0: it is at no place");
  expect_refused_after(landmark + "z = 1", "landmark 0: it is not in the plane of the map, and 2");
  expect_refused_after(landmark + "xy = 1000", "landmark 0: it has no covariance");
  expect_refused_after(landmark + "xx = -1", "it has no covariance");
  expect_refused_after(landmark + "xx = 1e-5, yy = 1e-5",
                       "its covariance and the prior contradict");
  expect_refused_after(landmark + "existence = -1e308", "no log odds of its existence");
  expect_refused_after(landmark + "sightings = 2147483647", "no number of sightings");
  expect_refused_after("UPDATE prior SET r11 = 1e-300 WHERE number = 0", "contradict");
  expect_refused_after("UPDATE prior SET r12 = 1e200 WHERE number = 0", "contradict");
  expect_refused_after("UPDATE landmark_size SET extent = 1e300", "an extent of more than");
  expect_refused_after("UPDATE landmark_class SET probability = 0.6", "do not sum to 1");
  expect_refused_after("UPDATE landmark_class SET probability = -0.5", "do not sum to 1");
  expect_refused_after("UPDATE keyframe SET x = -1e8", "keyframe 0 of session 1 is at no place");
  expect_refused_after("UPDATE keyframe SET time = 1e300", "is of no time");
  expect_refused_after(local + "x = x + 1e8", "a local map of session 1 is at no place on Earth");
  expect_refused_after(local + "angle = 1e300", "a local map of session 1 has no direction");
  expect_refused_after(local + "xx = 1e8, yy = 1e8, aa = 1e8", "has no covariance");
  expect_refused_after(local + "xy = 0.02", "has no covariance");
}

TEST_F(MapFileTest, WhatCouldNotBeReadAgainIsNotWritten) {
  const std::string before = read("a.hmap");
  MapRecord map = small_map();
  map.local_maps.front().covariance *= 1e10;
  EXPECT_THROW(MapFile(at("a.hmap")).replace(map), Error);
  EXPECT_TRUE(read("a.hmap") == before);
}

TEST_F(MapFileTest, KnowsWhichFilesOfASessionAreLogsAndThePriorOfItsClasses) {
  MapRecord map = small_map();
  map.sessions[0].inputs = {{"logs/a.rawlog", "01"}, {"a.ini", "02"}, {"truth.txt", "03"}};
  map.sessions[0].configuration =
      R"({"log":{"rawlog":"../logs/a.rawlog"},"BearingRangeAssociation":{"class_prior":"3 1"}})";
  map.sessions[1].inputs = {{"b.rawlog", "04"}, {"a.ini", "02"}, {"c.rawlog", "05"}};
  map.sessions[1].configuration =
      R"({"robot.anna":{"rawlog":"b.rawlog"},"robot.bert":{"rawlog":"c.rawlog"},"log":{"x":1}})";
  MapFile(at("b.hmap")).replace(map);
  const MapRecord read = read_map(at("b.hmap"));
  EXPECT_EQ(read.sessions[0].logs, std::vector<std::string>({"01"}));
  EXPECT_EQ(read.sessions[0].class_prior, std::vector<double>({0.75, 0.25}));
  EXPECT_EQ(read.sessions[1].logs, std::vector<std::string>({"04", "05"}));
  EXPECT_TRUE(read.sessions[1].class_prior.empty());
}

TEST_F(MapFileTest, RobotsHaveNamesThatMakeFiles) {
  expect_refused_after("UPDATE robot SET name = 'anna'", "session 2 has two robots named anna");
  expect_refused_after("UPDATE robot SET name = '../x' WHERE number = 0", "no name of a robot");
}

TEST_F(MapFileTest, AChangedDigitIsSeen) {
  expect_refused_after("UPDATE landmark SET x = x + 1e-9", "checksum");
  expect_refused_after("UPDATE session SET configuration = '{}' WHERE id = 1", "checksum");
  expect_refused_after("DELETE FROM map WHERE name = 'checksum'", "checksum");
}

TEST_F(MapFileTest, AFlippedBitChangesNoNumber) {
  const std::string sound = read("a.hmap");
  const std::vector<double> numbers = numbers_of(read_map(at("a.hmap")));
  std::mt19937_64 random(2);
  int refused = 0;
  for (int i = 0; i < 200; ++i) {
    std::string bytes = sound;
    const std::size_t bit = random() % (8 * bytes.size());
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8)));
    write("b.hmap", bytes);
    try {
      EXPECT_EQ(numbers_of(read_map(at("b.hmap"))), numbers) << bit;
    } catch (const Error& e) {
      ++refused;
      const std::string message = e.what();
      EXPECT_TRUE(std::none_of(message.begin(), message.end(), [](unsigned char c) {
        return std::iscntrl(c) != 0;
      })) << bit;
    }
  }
  EXPECT_GT(refused, 20);  // the others hit bytes that hold nothing
}

TEST_F(MapFileTest, FilesWithoutChecksumAreReadAndGetOne) {
  run_sql(at("a.hmap"),
          "DROP TABLE landmark_size; DROP TABLE surface; DROP TABLE local_map; "
          "DELETE FROM map WHERE name = 'checksum'; PRAGMA user_version = 2");
  EXPECT_EQ(read_map(at("a.hmap")).sessions.size(), 2U);
  EXPECT_TRUE(read_map(at("a.hmap")).local_maps.empty());
  EXPECT_FALSE(has_checksum(at("a.hmap")));
  MapFile file(at("a.hmap"));
  file.replace(file.record());
  EXPECT_TRUE(has_checksum(at("a.hmap")));
}

TEST_F(MapFileTest, WhatLandmarksCannotStandForIsRefused) {
  const std::string change = "UPDATE landmark_size SET ";
  expect_refused_after(change + "things = 0", "0");
  expect_refused_after(change + "things = 'x'", "no whole number");
  expect_refused_after(change + "extent = -0.1", "landmark 10: it has a negative extent");
  expect_refused_after(change + "extent = 9e999", "finite");
  expect_refused_after("PRAGMA foreign_keys = OFF; " + change + "landmark = 7",
                       "rows of a landmark 7 that is not there");
  expect_refused_after(change + "things = 4", "checksum");
}

TEST_F(MapFileTest, WhatLandmarksStandForIsInTheResult) {
  const MapResult result = result_of(read_map(at("a.hmap")), "");
  ASSERT_EQ(result.landmarks.size(), 3U);
  EXPECT_EQ(result.landmarks[1].size.things, 3);
  EXPECT_EQ(result.landmarks[1].size.extent, 0.25);
}

TEST_F(MapFileTest, FilesWithoutSizesAreReadAndGetThem) {
  MapRecord single = small_map();
  single.landmarks[1].size = {};
  MapFile(at("a.hmap")).replace(single);
  run_sql(at("a.hmap"), "DROP TABLE landmark_size; PRAGMA user_version = 4");
  EXPECT_EQ(read_map(at("a.hmap")).landmarks[1].size.things, 1);
  MapFile(at("a.hmap")).replace(small_map());
  EXPECT_EQ(read_map(at("a.hmap")).landmarks[1].size.things, 3);
}

TEST_F(MapFileTest, ASessionThatIsNotedHasAChecksumToo) {
  MapFile file(at("a.hmap"));
  const int id = file.begin({}, false);
  file.note(id, {{0, small_map().sessions[0].keyframes[0]}}, {});
  EXPECT_EQ(read_map(at("a.hmap")).sessions.back().keyframes.size(), 1U);
}

TEST_F(MapFileTest, AChangeOfNothingChangesNoByte) {
  const std::string before = read("a.hmap");
  {
    MapFile file(at("a.hmap"));
    file.replace(file.record());
  }
  EXPECT_TRUE(read("a.hmap") == before);
}

TEST_F(MapFileTest, WhatIsNotChangedStaysAsItIs) {
  const MapRecord whole = read_map(at("a.hmap"));
  const auto prune = [&] {
    MapFile file(at("a.hmap"));
    MapRecord map = file.record();
    map.sessions[0].keyframes.clear();
    file.replace(map);
  };
  prune();
  const std::string once = read("a.hmap");
  prune();
  EXPECT_TRUE(read("a.hmap") == once);
  MapRecord same = read_map(at("a.hmap"));
  EXPECT_TRUE(same.sessions[0].keyframes.empty());
  same.sessions[0].keyframes = whole.sessions[0].keyframes;
  EXPECT_EQ(numbers_of(same), numbers_of(whole));
}

TEST_F(MapFileTest, OneProcessWritesAMapUnderAllItsNames) {
  std::filesystem::create_symlink("a.hmap", at("link.hmap"));
  std::filesystem::create_symlink("link.hmap", at("link2.hmap"));
  {
    const MapFile writer(at("a.hmap"));
    EXPECT_THROW(MapFile(at("link2.hmap")), Error);
  }
  MapFile(at("link2.hmap")).begin({}, false);
  EXPECT_TRUE(std::filesystem::is_symlink(at("link.hmap")));
  EXPECT_EQ(read_map(at("a.hmap")).sessions.size(), 3U);
  std::filesystem::create_symlink("new.hmap", at("dangling.hmap"));
  const MapFile made(at("dangling.hmap"));
  EXPECT_THROW(MapFile(at("new.hmap")), Error);
  std::filesystem::create_hard_link(at("a.hmap"), at("hard.hmap"));
  EXPECT_THROW(MapFile(at("hard.hmap")), Error);
}

TEST_F(MapFileTest, IsARegularFile) {
  ASSERT_EQ(mkfifo(at("pipe.hmap").c_str(), 0600), 0);
  expect_refused("pipe.hmap", "is a pipe, not a map file");
  std::filesystem::create_symlink("/dev/zero", at("zero.hmap"));
  expect_refused("zero.hmap", "is a device, not a map file");
  std::filesystem::create_directory(at("folder.hmap"));
  expect_refused("folder.hmap", "is a folder, not a map");
}

}  // namespace
}  // namespace hybrid
