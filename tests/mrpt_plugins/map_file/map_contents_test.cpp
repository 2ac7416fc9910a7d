// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "tests/mrpt_plugins/map_file/small_map.h"

namespace hybrid {
namespace {

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

TEST_F(MapFileTest, HoldsLocalCloudsOfTheirForm) {
  const std::string change = "UPDATE local_cloud SET ";
  expect_refused_after("DELETE FROM local_cloud WHERE number = 0", "are not of their form");
  expect_refused_after(change + "session = 9 WHERE session = 2", "session 9");
  expect_refused_after(change + "x = 9e999", "is not finite");
  expect_refused_after(change + "y = 1e8", "a local cloud of session 1 is at no place on Earth");
  expect_refused_after(change + "qw = 7", "a local cloud of session 1 has no direction");
  expect_refused_after(change + "covariance = zeroblob(288)", "has no covariance");
  expect_refused_after(change + "covariance = zeroblob(280)", "is cut off after 280 bytes");
  expect_refused_after(change + "covariance = zeroblob(576)", "has no covariance");
  expect_refused_after(change + "covariance = 'x'", "is no bytes");
  expect_refused_after(change + "spacing = 0", "has no spacing");
  expect_refused_after(change + "points = zeroblob(16)", "is cut off after 16 bytes");
  expect_refused_after(change + "points = x'ffffff7fffffff7fffffff7f000000'",
                       "has points that no sensor sees");
  expect_refused_after(change + "points = zeroblob(15)", "checksum");
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
  const std::string parent = "UPDATE place_parent SET ";
  expect_refused_after(parent + "parent = number", "session 1 is known beside none before it");
  expect_refused_after(parent + "covariance = zeroblob(72)", "is known beside none before it");
  expect_refused_after(parent + "covariance = zeroblob(64)", "is cut off");
  expect_refused_after(parent + "parent = 7", "names a local map that is not there");
}

TEST_F(MapFileTest, WhatCouldNotBeReadAgainIsNotWritten) {
  const std::string before = read("a.hmap");
  MapRecord map = small_map();
  map.local_maps.front().covariance *= 1e10;
  EXPECT_THROW(MapFile(at("a.hmap")).replace(map), Error);
  EXPECT_TRUE(read("a.hmap") == before);
}

}  // namespace
}  // namespace hybrid
