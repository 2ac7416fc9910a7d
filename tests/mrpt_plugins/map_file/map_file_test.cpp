// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/map_file/map_file.h"

#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/map_file/export_map.h"
#include "tests/mrpt_plugins/map_file/small_map.h"

namespace hybrid {
namespace {

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
          "DROP TABLE local_cloud; DROP TABLE place_parent; DELETE FROM map WHERE name = "
          "'checksum'; PRAGMA user_version = 2");
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
  for (MapLocalMap& local : single.local_maps) local.parent.reset();
  single.local_clouds.clear();
  MapFile(at("a.hmap")).replace(single);
  run_sql(at("a.hmap"),
          "DROP TABLE landmark_size; DROP TABLE local_cloud; DROP TABLE place_parent; PRAGMA "
          "user_version = 4");
  EXPECT_EQ(read_map(at("a.hmap")).landmarks[1].size.things, 1);
  MapFile(at("a.hmap")).replace(small_map());
  EXPECT_EQ(read_map(at("a.hmap")).landmarks[1].size.things, 3);
}

TEST_F(MapFileTest, FilesWithoutParentsAreReadAndGetThem) {
  MapRecord alone = small_map();
  for (MapLocalMap& local : alone.local_maps) local.parent.reset();
  MapFile(at("a.hmap")).replace(alone);
  run_sql(at("a.hmap"), "DROP TABLE place_parent; PRAGMA user_version = 6");
  EXPECT_FALSE(read_map(at("a.hmap")).local_maps[3].parent);
  MapFile(at("a.hmap")).replace(small_map());
  EXPECT_EQ(read_map(at("a.hmap")).local_maps[3].parent->place, 2U);
}

TEST_F(MapFileTest, LocalMapsThatGoTakeWhatIsKnownBesideThemAlong) {
  MapRecord map = small_map();
  map.local_maps[2].parent = {1, 1e-4 * Eigen::Matrix3d::Identity()};
  forget_local_maps(map, 1);
  ASSERT_EQ(map.local_maps.size(), 2U);
  EXPECT_FALSE(map.local_maps[0].parent);
  EXPECT_EQ(map.local_maps[1].parent->place, 0U);
  EXPECT_EQ(map.local_clouds.size(), 2U);
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

TEST_F(MapFileTest, ANewOneIsThereFromItsFirstChangeOn) {
  { const MapFile opened(at("new.hmap")); }
  EXPECT_FALSE(std::filesystem::exists(at("new.hmap")));
  write("empty.hmap", "");
  { const MapFile opened(at("empty.hmap")); }
  EXPECT_EQ(read("empty.hmap"), "");
  MapRecord wrong = small_map();
  wrong.landmarks[0].existence = std::nan("");
  EXPECT_THROW(MapFile(at("new.hmap")).replace(wrong), Error);
  EXPECT_THROW(
      MapFile(at("new.hmap")).replace(small_map(), [] { throw Error("the disk is full"); }), Error);
  EXPECT_FALSE(std::filesystem::exists(at("new.hmap")));
  MapFile(at("new.hmap")).replace(small_map());
  EXPECT_EQ(numbers_of(read_map(at("new.hmap"))), numbers_of(read_map(at("a.hmap"))));
}

TEST_F(MapFileTest, AByteIsNoMap) {
  write("byte.hmap", "f");
  expect_refused("byte.hmap", "is no map: not a SQLite database");
}

TEST_F(MapFileTest, HasANameAndIsNoDatabaseInMemory) {
  EXPECT_THROW(MapFile(""), Error);
  const std::filesystem::path here = std::filesystem::current_path();
  std::filesystem::current_path(at(""));
  MapFile(":memory:").replace(small_map());
  std::filesystem::current_path(here);
  EXPECT_EQ(read_map(at(":memory:")).sessions.size(), 2U);
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
