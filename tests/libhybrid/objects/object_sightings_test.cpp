// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/objects/object_sightings.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "libhybrid/core/error.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

class ObjectSightings : public ScratchFolder {
 protected:
  ObjectSightings() {
    write("odom.txt", "# t x y z qx qy qz qw\n0 0 0 0 0 0 0 1\n0.1 1 0 0 0 0 0 1\n");
    write("det_cup.txt", "0 0 0 2 0 0 0 1\n0.1 0 0 0 0 0 0 0\n");
  }
  ObjectSequence read() const { return read_object_sequence(folder.string()); }
  /// The message of the error that reading ends with.
  std::string message() const {
    try {
      read();
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  }
};

TEST_F(ObjectSightings, AreReadFrameByFrame) {
  write("objgt_cup.txt", "0 0 0 2.5 0 0 0 1\n0.1 -1 0 2.5 0 0 0 1\n");
  const ObjectSequence sequence = read();
  ASSERT_EQ(sequence.odometry.size(), 2u);
  EXPECT_DOUBLE_EQ(sequence.odometry[1].translation().x(), 1.0);
  EXPECT_TRUE(sequence.truth.empty());
  ASSERT_EQ(sequence.objects.size(), 1u);
  EXPECT_EQ(sequence.objects[0].name, "cup");
  ASSERT_TRUE(sequence.objects[0].sightings[0]);
  EXPECT_DOUBLE_EQ(sequence.objects[0].sightings[0]->translation().z(), 2.0);
  EXPECT_FALSE(sequence.objects[0].sightings[1]) << "zeros are no detection";
  EXPECT_DOUBLE_EQ(sequence.objects[0].truth[1]->translation().x(), -1.0);
}

TEST_F(ObjectSightings, BadRowsAreNamed) {
  write("det_cup.txt", "0 0 0 2 0 0 0 1\n0.1 0 0 oops 0 0 0 1\n");
  EXPECT_NE(message().find("det_cup.txt:2:9: 'oops' is not a number"), std::string::npos)
      << message();
  write("det_cup.txt", "0 0 0 2 0 0 0 3\n0.1 0 0 0 0 0 0 1\n");
  EXPECT_NE(message().find("det_cup.txt:1:9: the quaternion"), std::string::npos) << message();
}

TEST_F(ObjectSightings, RowsMustFitTheOdometry) {
  write("det_cup.txt", "0 0 0 2 0 0 0 1\n");
  EXPECT_NE(message().find("has 1 rows, odom.txt has 2"), std::string::npos) << message();
  write("det_cup.txt", "0 0 0 2 0 0 0 1\n0.7 0 0 2 0 0 0 1\n");
  EXPECT_NE(message().find("row 2 is of time"), std::string::npos) << message();
}

TEST_F(ObjectSightings, MissingFilesAreNamed) {
  fs::remove(folder / "odom.txt");
  EXPECT_NE(message().find("odom.txt: no such file"), std::string::npos) << message();
  fs::remove(folder / "det_cup.txt");
  EXPECT_NE(message().find("holds no sightings"), std::string::npos) << message();
  EXPECT_THROW(read_object_sequence((folder / "absent").string()), Error);
}

}  // namespace
}  // namespace hybrid
