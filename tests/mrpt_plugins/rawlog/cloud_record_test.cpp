// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/system/datetime.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "mrpt_plugins/input/clouds.h"
#include "mrpt_plugins/rawlog/log_record.h"

namespace hybrid {
namespace {

using mrpt::maps::CSimplePointsMap;
using mrpt::obs::CObservation;
using mrpt::obs::CObservation3DRangeScan;
using mrpt::obs::CObservationPointCloud;
using mrpt::obs::CObservationVelodyneScan;

/// What a program gets of an observation, which asks for classes by name.
CObservation::Ptr read_back(const CObservation::Ptr& content,
                            const std::vector<std::string>& classes) {
  register_mrpt_classes();
  const AskedClasses asked(classes);
  RecordReader reader(asked, 1U << 24);
  const LoggedObservation logged{
      content->GetRuntimeClass()->className, content->timestamp, content, {}};
  reader.add(to_bytes(LogObject(logged), asked));
  return std::get<LoggedObservation>(std::get<LogObject>(*reader.next())).content;
}

CObservationPointCloud::Ptr two_points() {
  auto out = CObservationPointCloud::Create();
  out->sensorLabel = "LIDAR";
  out->sensorPose = mrpt::poses::CPose3D(0.1, -0.2, 1.5, 0.4, 0, 0);
  const auto map = CSimplePointsMap::Create();
  map->insertPointFast(1, 2, 3);
  map->insertPointFast(-4, 5, 6);
  out->pointcloud = map;
  return out;
}

TEST(CloudRecord, PointsAndSensorPoseComeWhereAskedFor) {
  EXPECT_FALSE(read_back(two_points(), {}));
  const auto back = std::dynamic_pointer_cast<CObservationPointCloud>(
      read_back(two_points(), {"CObservationPointCloud"}));
  ASSERT_TRUE(back && back->pointcloud);
  EXPECT_EQ(back->sensorLabel, "LIDAR");
  EXPECT_EQ(back->sensorPose, two_points()->sensorPose);
  ASSERT_EQ(back->pointcloud->size(), 2U);
  float x = 0, y = 0, z = 0;
  back->pointcloud->getPoint(1, x, y, z);
  EXPECT_NEAR(x, -4, 1e-5);
  EXPECT_NEAR(y, 5, 1e-5);
  EXPECT_NEAR(z, 6, 1e-5);
}

TEST(CloudRecord, ADepthImageComesAsACloud) {
  auto depth = CObservation3DRangeScan::Create();
  depth->hasRangeImage = true;
  depth->range_is_depth = true;
  depth->rangeUnits = 0.001F;
  depth->rangeImage_setSize(4, 6);
  depth->rangeImage.fill(2000);
  depth->cameraParams.ncols = 6;
  depth->cameraParams.nrows = 4;
  depth->cameraParams.setIntrinsicParamsFromValues(5, 5, 3, 2);
  DropReport dropped;
  const auto back = read_back(depth, {"CObservationPointCloud"});
  ASSERT_TRUE(back);
  const auto cloud = cloud_in(*back, dropped);
  ASSERT_TRUE(cloud) << (dropped.empty() ? "" : dropped.begin()->first);
  EXPECT_EQ(cloud->points.size(), 24U);
  for (const Eigen::Vector3f& p : cloud->points) EXPECT_NEAR(p.x(), 2, 1e-4) << "x is ahead";
}

TEST(CloudRecord, PointsInAFileBesideTheLogAreNotRead) {
  auto cloud = CObservationPointCloud::Create();
  cloud->setAsExternalStorage("/etc/passwd",
                              CObservationPointCloud::ExternalStorageFormat::KittiBinFile);
  const auto back = read_back(cloud, {"CObservationPointCloud"});
  ASSERT_TRUE(back);
  DropReport dropped;
  EXPECT_FALSE(cloud_in(*back, dropped));
  EXPECT_EQ(dropped["cloud dropped: its points are in a file beside the log"], 1U);
}

CObservationVelodyneScan::Ptr sweep_of(const std::vector<double>& times) {
  auto out = CObservationVelodyneScan::Create();
  out->timestamp = mrpt::Clock::fromDouble(1.7e9);
  out->point_cloud.x = {1, std::numeric_limits<float>::infinity(), 3};
  out->point_cloud.y = out->point_cloud.z = {0, 0, 0};
  for (const double time : times) {
    out->point_cloud.timestamp.push_back(
        std::isnan(time) ? INVALID_TIMESTAMP : mrpt::system::timestampAdd(out->timestamp, time));
  }
  return out;
}

TEST(CloudRecord, TimesOfPointsComeRelativeToTheStamp) {
  DropReport dropped;
  const auto cloud =
      cloud_in(*read_back(sweep_of({-0.05, 0, 0.05}), {"CObservationPointCloud"}), dropped);
  ASSERT_TRUE(cloud);
  EXPECT_NEAR(cloud->stamp, 1.7e9, 1e-6);
  ASSERT_EQ(cloud->points.size(), 2U) << "one is not finite";
  ASSERT_EQ(cloud->times.size(), 2U);
  EXPECT_NEAR(cloud->times[0], -0.05, 1e-6);
  EXPECT_NEAR(cloud->times[1], 0.05, 1e-6);
  EXPECT_TRUE(dropped.empty());
}

TEST(CloudRecord, TimesThatAreNoneOrTooFew) {
  DropReport dropped;
  const auto times_of = [&](const CObservationVelodyneScan::Ptr& sweep) {
    return cloud_in(*read_back(sweep, {"CObservationPointCloud"}), dropped).value().times;
  };
  EXPECT_TRUE(times_of(sweep_of({})).empty());
  EXPECT_TRUE(std::isnan(times_of(sweep_of({NAN, 0, 0.05})).at(0)));
  auto unstamped = sweep_of({0, 0, 0});
  unstamped->timestamp = INVALID_TIMESTAMP;
  EXPECT_TRUE(times_of(unstamped).empty());
  auto hostile = sweep_of({0, 0, 0});
  using Time = mrpt::system::TTimeStamp;
  hostile->timestamp = Time(Time::duration(std::numeric_limits<std::int64_t>::min() + 1));
  EXPECT_EQ(times_of(hostile).size(), 2U);
  EXPECT_TRUE(dropped.empty());
  for (const auto& some : {std::vector<double>{0, 0}, {0, 0, 0, 0}}) {
    EXPECT_TRUE(times_of(sweep_of(some)).empty());
  }
  EXPECT_EQ(dropped["times of a cloud dropped: they are not as many as its points"], 2U);
}

/// A packet of a VLP-16 whose rays all meet something at 10 m.
CObservationVelodyneScan::TVelodyneRawPacket packet(std::uint32_t microseconds) {
  using Scan = CObservationVelodyneScan;
  std::string bytes;
  const auto put = [&](auto number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  for (int block = 0; block < Scan::BLOCKS_PER_PACKET; ++block) {
    put(std::uint16_t{Scan::UPPER_BANK});
    put(static_cast<std::uint16_t>(40 * block));
    for (int ray = 0; ray < Scan::SCANS_PER_BLOCK; ++ray) {
      put(std::uint16_t{5000});
      put(std::uint8_t{7});
    }
  }
  put(microseconds);
  put(Scan::RETMODE_STRONGEST);
  put(std::uint8_t{0x22});
  Scan::TVelodyneRawPacket out;
  EXPECT_EQ(bytes.size(), sizeof out);
  std::memcpy(static_cast<void*>(&out), bytes.data(), sizeof out);
  return out;
}

TEST(CloudRecord, PacketsOfALidarTellTimes) {
  auto sweep = CObservationVelodyneScan::Create();
  sweep->timestamp = mrpt::Clock::fromDouble(1.7e9);
  sweep->calibration = mrpt::obs::VelodyneCalibration::LoadDefaultCalibration("VLP16");
  sweep->sensorPose = mrpt::poses::CPose3D(0, 0, 2, 0, 0, 0);
  sweep->scan_packets = {packet(3'599'990'000), packet(30'000)};  // over the hour
  DropReport dropped;
  const auto cloud = cloud_in(*read_back(sweep, {"CObservationPointCloud"}), dropped);
  ASSERT_TRUE(cloud);
  ASSERT_GT(cloud->points.size(), 100U);
  ASSERT_EQ(cloud->times.size(), cloud->points.size());
  EXPECT_NEAR(cloud->times.front(), 0, 1e-6);
  EXPECT_NEAR(cloud->times.back(), 0.04, 1e-6);
  EXPECT_NEAR((cloud->points[0] - cloud->sensor).norm(), 10, 1e-3);
}

TEST(CloudIn, PointsAreWhereTheRobotHasThem) {
  DropReport dropped;
  const auto cloud = cloud_in(*two_points(), dropped);
  ASSERT_TRUE(cloud);
  EXPECT_NEAR(cloud->sensor.z(), 1.5, 1e-6);
  const double c = std::cos(0.4), s = std::sin(0.4);
  EXPECT_NEAR(cloud->points[0].x(), 0.1 + c - 2 * s, 1e-5);
  EXPECT_NEAR(cloud->points[0].z(), 4.5, 1e-5);
  auto empty = two_points();
  empty->pointcloud = CSimplePointsMap::Create();
  EXPECT_FALSE(cloud_in(*empty, dropped));
  EXPECT_TRUE(is_empty_cloud(*empty));
  const auto unseen = CSimplePointsMap::Create();
  unseen->insertPointFast(std::nanf(""), 0, 0);
  empty->pointcloud = unseen;
  EXPECT_FALSE(cloud_in(*empty, dropped));
  EXPECT_TRUE(is_empty_cloud(*empty));
  EXPECT_FALSE(is_empty_cloud(*two_points()));
  auto far = two_points();
  far->sensorPose = mrpt::poses::CPose3D(1e9, 0, 0, 0, 0, 0);
  EXPECT_FALSE(cloud_in(*far, dropped));
  EXPECT_FALSE(is_empty_cloud(*far));
  EXPECT_EQ(dropped["cloud dropped: no points"], 2U);
  EXPECT_EQ(dropped["cloud dropped: sensor pose absurd"], 1U);
}

}  // namespace
}  // namespace hybrid
