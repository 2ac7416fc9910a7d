// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/observations/classed_bearing_range.h"

#include <gtest/gtest.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include <filesystem>

#include "tests/support/rawlog_edit.h"

namespace hybrid {
namespace {

CObservationClassedBearingRange example() {
  CObservationClassedBearingRange o;
  o.sensorLabel = "DETECTOR";
  o.timestamp = mrpt::Clock::fromDouble(1.75e9);
  o.sensor_pose = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  o.min_range = 0.5F;
  o.max_range = 12;
  o.fov_yaw = 2;
  o.fov_pitch = 1;
  o.std_range = 0.05F;
  o.std_yaw = 0.01F;
  o.std_pitch = 0.02F;
  o.has_pitch = true;
  o.class_names = {"tree", "car"};
  o.detections.push_back({3.5F, 0.25F, -0.125F, 7, 7, {0.75F, 0.25F}});
  o.detections.push_back({1.5F, -0.5F, 0.0F, -1, 4, {}});
  return o;
}

TEST(ClassedBearingRange, SerialisesEverything) {
  const auto o = example();
  mrpt::io::CMemoryStream memory;
  auto archive = mrpt::serialization::archiveFrom(memory);
  archive << o;
  memory.Seek(0);
  const auto object = archive.ReadObject();
  const auto back = std::dynamic_pointer_cast<CObservationClassedBearingRange>(object);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->sensorLabel, o.sensorLabel);
  EXPECT_EQ(back->timestamp, o.timestamp);
  EXPECT_NEAR(back->sensor_pose.distanceTo(o.sensor_pose), 0, 1e-12);
  EXPECT_EQ(back->min_range, o.min_range);
  EXPECT_EQ(back->max_range, o.max_range);
  EXPECT_EQ(back->fov_yaw, o.fov_yaw);
  EXPECT_EQ(back->fov_pitch, o.fov_pitch);
  EXPECT_EQ(back->std_range, o.std_range);
  EXPECT_EQ(back->std_yaw, o.std_yaw);
  EXPECT_EQ(back->std_pitch, o.std_pitch);
  EXPECT_EQ(back->has_pitch, o.has_pitch);
  EXPECT_EQ(back->class_names, o.class_names);
  ASSERT_EQ(back->detections.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(back->detections[i].range, o.detections[i].range);
    EXPECT_EQ(back->detections[i].yaw, o.detections[i].yaw);
    EXPECT_EQ(back->detections[i].pitch, o.detections[i].pitch);
    EXPECT_EQ(back->detections[i].landmark_id, o.detections[i].landmark_id);
    EXPECT_EQ(back->detections[i].true_landmark_id, o.detections[i].true_landmark_id);
    EXPECT_EQ(back->detections[i].class_scores, o.detections[i].class_scores);
  }
}

TEST(ClassedBearingRange, DescribesItself) {
  const std::string text = example().asString();
  for (const char* part : {"DETECTOR", "tree car", "2 detections", "3.500"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " not in " << text;
  }
  EXPECT_EQ(example().exportTxtDataRow(), "2 3.5 0.25 -0.125 7 7 tree 1.5 -0.5 0 -1 4 -");
}

TEST(ClassedBearingRange, RawlogEditReadsItThroughThePlugin) {
  const std::string why = why_rawlog_edit_cannot();
  if (!why.empty()) GTEST_SKIP() << why;
  const std::string log = ::testing::TempDir() + "classed_bearing_range_test.rawlog";
  {
    mrpt::io::CFileGZOutputStream file(log);
    auto archive = mrpt::serialization::archiveFrom(file);
    for (int i = 0; i < 5; ++i) {
      mrpt::obs::CSensoryFrame frame;
      frame.insert(std::make_shared<CObservationClassedBearingRange>(example()));
      mrpt::obs::CActionRobotMovement2D motion;
      mrpt::obs::CActionCollection actions(motion);
      archive << actions << frame;
    }
  }
  const std::string plugin = HYBRID_BINARY_DIR "/lib/libhybrid_mrpt.so";
  ASSERT_TRUE(std::filesystem::exists(plugin));
  const auto said = [](const std::string& command) { return run_shell(command + " 2>&1").text; };
  const std::string with = said("rawlog-edit -p " + plugin + " -i " + log + " --info");
  EXPECT_NE(with.find("Overall number of objects         : 10"), std::string::npos) << with;
  EXPECT_NE(with.find("DETECTOR /      5"), std::string::npos) << with;
  EXPECT_EQ(with.find("not registered"), std::string::npos) << with;
  const std::string without = said("rawlog-edit -i " + log + " --info");
  EXPECT_NE(without.find("not registered"), std::string::npos) << without;
  std::filesystem::remove(log);
}

TEST(ClassedBearingRange, SerialisesSigmasAndDirectionsAlone) {
  const auto round_trip = [](const CObservationClassedBearingRange& o) {
    mrpt::io::CMemoryStream memory;
    auto archive = mrpt::serialization::archiveFrom(memory);
    archive << o;
    memory.Seek(0);
    return std::dynamic_pointer_cast<CObservationClassedBearingRange>(archive.ReadObject());
  };
  auto o = example();
  EXPECT_TRUE(round_trip(o)->has_range);
  o.detections[1].std_yaw = 0.5F;
  EXPECT_EQ(round_trip(o)->detections.at(1).std_yaw, 0.5F);
  EXPECT_EQ(round_trip(o)->detections.at(0).std_yaw, 0.0F);
  o.has_range = false;
  EXPECT_FALSE(round_trip(o)->has_range);
  EXPECT_EQ(round_trip(o)->detections.at(1).std_yaw, 0.5F);
  EXPECT_EQ(round_trip(o)->detections.at(0).class_scores, o.detections[0].class_scores);
}

}  // namespace
}  // namespace hybrid
