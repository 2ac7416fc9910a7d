// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/obs/CRawlog.h>

#include <cmath>
#include <cstdint>

#include "mrpt_plugins/import/clouds.h"
#include "mrpt_plugins/input/clouds.h"
#include "tests/mrpt_plugins/import/import_files.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservationVelodyneScan;

constexpr std::uint64_t kDay = 1'700'000'000;  // s since 1970

template <class Number>
std::string raw_of(Number number) {
  return {reinterpret_cast<const char*>(&number), sizeof number};
}

std::string pcd_header(const std::string& field, int size, char type, const std::string& data) {
  return "VERSION 0.7\nFIELDS x y z " + field + "\nSIZE 4 4 4 " + std::to_string(size) +
         "\nTYPE F F F " + type + "\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA " + data +
         "\n";
}

class CloudTimes : public ImportTest {
 protected:
  CloudTimes() {
    std::filesystem::create_directory(at("in"));
    options.folder = at("in");
  }

  /// Two points of these times.
  template <class Number>
  void pcd(const std::string& name, const std::string& field, char type, Number a, Number b) const {
    std::string out = pcd_header(field, sizeof(Number), type, "binary");
    for (const Number time : {a, b}) {
      out += raw_of(1.F) + raw_of(2.F) + raw_of(3.F) + raw_of(time);
    }
    write("in/" + name, out);
  }

  ImportReport import() { return import_clouds(options, log()); }

  std::vector<PointCloud> clouds() const {
    RawlogOptions reading;
    reading.request.classes = {"CObservationPointCloud"};
    RawlogReader reader(log(), reading);
    std::vector<PointCloud> all;
    DropReport dropped;
    while (const auto step = reader.next()) {
      all.push_back(cloud_in(*step->observations.at(0), dropped).value());
    }
    EXPECT_EQ(reader.status(), LogStatus::kComplete) << reader.message();
    EXPECT_TRUE(dropped.empty());
    return all;
  }

  CloudsOptions options;
};

TEST_F(CloudTimes, OfEachFormAreRelativeToTheCloud) {
  options.period = 0.5;
  pcd("0.pcd", "t", 'F', -0.05F, 0.05F);
  pcd("1.pcd", "offset_time", 'U', std::uint32_t{10'000'000}, std::uint32_t{90'000'000});
  write("in/2.pcd", pcd_header("time", 8, 'F', "ascii") + "1 2 3 0.01\n1 2 3 nan\n");
  write("in/3.ply",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nproperty uint t\nend_header\n1 2 3 20000000\n1 2 3 30000000\n");
  write("in/4.ply",
        "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty double time\nproperty "
        "float x\nproperty float y\nproperty float z\nend_header\n" +
            raw_of(0.04) + raw_of(1.F) + raw_of(2.F) + raw_of(3.F) + raw_of(0.05) + raw_of(1.F) +
            raw_of(2.F) + raw_of(3.F));
  write("in/5.pcd", pcd_header("intensity", 4, 'F', "ascii") + "1 2 3 0.01\n1 2 3 0.02\n");
  const ImportReport report = import();
  EXPECT_TRUE(tells(report, "points have times"));
  EXPECT_EQ(count_notes(report, "another clock"), 0);
  EXPECT_EQ(report.dropped.at("time of a point dropped: not within a second of its cloud"), 1U);
  const auto all = clouds();
  ASSERT_EQ(all.size(), 6U);
  const float expected[][2] = {
      {-0.05F, 0.05F}, {0.01F, 0.09F}, {0.01F, NAN}, {0.02F, 0.03F}, {0.04F, 0.05F}};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(all[i].stamp, 0.5 * static_cast<double>(i), 1e-6);
    ASSERT_EQ(all[i].times.size(), 2U) << i;
    for (std::size_t k = 0; k < 2; ++k) {
      if (std::isnan(expected[i][k])) {
        EXPECT_TRUE(std::isnan(all[i].times[k]));
      } else {
        EXPECT_NEAR(all[i].times[k], expected[i][k], 1e-6) << i;
      }
    }
  }
  EXPECT_TRUE(all[5].times.empty());
}

TEST_F(CloudTimes, AbsoluteOnesAreOfTheClockOfTheCloudsOrOfAnother) {
  pcd("1700000000.25.pcd", "timestamp", 'F', double(kDay) + 0.2, double(kDay) + 0.3);
  pcd("1700000000.75.pcd", "timestamp", 'U', kDay * 1'000'000'000 + 800'000'000,
      kDay * 1'000'000'000 + 750'000'000);
  pcd("1700000001.25.pcd", "timestamp", 'F', 5000.1, 5000.0);
  pcd("1700000001.75.pcd", "timestamp", 'F', 5000.0, 7000.0);
  const ImportReport report = import();
  EXPECT_TRUE(tells(report, "of another clock"));
  EXPECT_EQ(report.dropped.at("time of a point dropped: not within a second of its cloud"), 1U);
  const auto all = clouds();
  ASSERT_EQ(all.size(), 4U);
  EXPECT_NEAR(all[0].times.at(0), -0.05, 2e-6);
  EXPECT_NEAR(all[0].times.at(1), 0.05, 2e-6);
  EXPECT_NEAR(all[1].times.at(0), 0.05, 2e-6);
  EXPECT_NEAR(all[1].times.at(1), 0, 2e-6);
  EXPECT_NEAR(all[2].times.at(0), 0.1, 2e-6);
  EXPECT_NEAR(all[2].times.at(1), 0, 2e-6);
}

TEST_F(CloudTimes, StayWithTheirPoints) {
  std::string rows;
  for (int i = 0; i < 1000; ++i) {
    rows += std::to_string(0.01 * i) + (i % 7 == 0 ? " nan" : " 0") + " 0 " +
            std::to_string(0.0001 * i) + "\n";
  }
  std::string header = pcd_header("t", 4, 'F', "ascii");
  for (std::size_t at = header.find(" 2\n"); at != std::string::npos; at = header.find(" 2\n")) {
    header.replace(at, 3, " 1000\n");
  }
  write("in/0.pcd", header + rows);
  options.most_points = 100;
  options.max_range = 8;
  options.sensor_pose = {0.5, 0, 1, 0, 0, 0};
  import();
  const auto all = clouds();
  ASSERT_EQ(all.at(0).times.size(), all[0].points.size());
  EXPECT_LE(all[0].points.size(), 100U);
  EXPECT_GT(all[0].points.size(), 50U);
  for (std::size_t i = 0; i < all[0].points.size(); ++i) {
    EXPECT_NEAR(all[0].points[i].x(), 0.5 + 100 * all[0].times[i], 1e-4);
    EXPECT_NEAR(all[0].points[i].z(), 1, 1e-6);
  }
}

TEST_F(CloudTimes, MrptReadsThemBack) {
  pcd("0.pcd", "t", 'F', -0.05F, 0.05F);
  import();
  mrpt::obs::CRawlog rawlog;
  ASSERT_TRUE(rawlog.loadFromRawLogFile(log()));
  const auto frame =
      std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(rawlog.getAsGeneric(rawlog.size() - 1));
  ASSERT_TRUE(frame);
  const auto scan = frame->getObservationByClass<CObservationVelodyneScan>();
  ASSERT_TRUE(scan);
  EXPECT_EQ(scan->sensorLabel, "LIDAR");
  ASSERT_EQ(scan->point_cloud.timestamp.size(), 2U);
  EXPECT_NEAR(mrpt::system::timeDifference(scan->timestamp, scan->point_cloud.timestamp[1]), 0.05,
              1e-6);
  mrpt::maps::CSimplePointsMap map;
  map.insertionOptions.minDistBetweenLaserPoints = 0;
  EXPECT_TRUE(map.insertObservation(*scan));
  EXPECT_EQ(map.size(), 2U) << "as MRPT's own programs do";
}

}  // namespace
}  // namespace hybrid
