// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/foreign_file.h"

#include <gtest/gtest.h>

#include "tests/mrpt_plugins/input/log_files.h"
#include "tests/mrpt_plugins/rawlog/compressed.h"

namespace hybrid {
namespace {

TEST(ForeignFile, IsNamedWithWhatToDo) {
  const std::pair<std::string, std::string> cases[] = {
      {"# a comment\nVERTEX_SE2 0 0 0 0\n", "hybrid-pgo"},
      {"EDGE_SE3:QUAT 0 1 0", "hybrid-pgo"},
      {"VERTEX2 0 0 0 0\n", "hybrid-pgo"},
      {"\n\n[log]\nrawlog = a\n", "-c"},
      {"\xef\xbb\xbf[log]\nrawlog = a\n", "-c"},
      {"time,x,y,yaw\n0,0,0,0\n", "hybrid-import csv"},
      {"ply\nformat ascii 1.0\n", "hybrid-register"},
      {"# .PCD v.7\nVERSION .7\n", "hybrid-register"},
      {"some words\n", "text"},
      {std::string("\xff\xfe[\0l\0", 6), "UTF-16"},
      {std::string("\xfd") + "7zXZ" + std::string("\0\0", 2), "xz -d"},
      {"BZh91AY&SY", "bzip2"},
      {"PK\x03\x04 rest", "zip archive"},
      {"\x89PNG\r\n", "PNG"},
      {"\xff\xd8\xff\xe0", "JPEG"},
      {"#ROSBAG V2.0\n", "rosbag2rawlog"},
      {"\x89MCAP0\r\n", "mcap_to_csv"},
      {std::string("\x7f") + "ELF\2", "-p"},
      {"SQLite format 3" + std::string(85, '\0'), "ros2 bag convert"},
      {"SQLite format 3" + std::string(53, '\0') + "HMAP" + std::string(28, '\0'), "--map"},
      {gzip("x"), "twice"},
      {std::string(257, 'a') + "ustar", "tar archive"}};
  for (const auto& [bytes, part] : cases) {
    const std::string kind = foreign_kind(bytes);
    EXPECT_NE(kind.find(part), std::string::npos) << part << ": " << kind;
    EXPECT_EQ(kind.rfind("this is ", 0), 0U) << kind;
  }
}

TEST(ForeignFile, RawlogsAndBytesOfAnyKindAreNot) {
  const TemporaryFile log("own.rawlog");
  write_log(log.path(), {frame({observation(1)})});
  EXPECT_EQ(foreign_kind(decode(read_bytes(log.path())).bytes), "");
  EXPECT_EQ(foreign_kind(std::string("\x0c\0\0\0CSensoryFrame", 17)), "") << "an old log";
  EXPECT_EQ(foreign_kind(""), "");
  EXPECT_EQ(foreign_kind(std::string("\x01\x02\x03", 3)), "");
}

}  // namespace
}  // namespace hybrid
