// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "tests/apps/cloud_log.h"

namespace hybrid {
namespace {

/// Once around a hall and a quarter more.
class CloudOutputs : public CloudLogTest {
 protected:
  void SetUp() override {
    CloudLogTest::SetUp();
    const std::vector<SE3> way = testing::way_around_hall(0.5);
    write_clouds("in", testing::cluttered_hall(), way, 4);
    count_ = way.size();
  }
  static double error_of(const nlohmann::json& summary) {
    return summary["truth"]["trajectory"]["rmse_m"];
  }
  std::size_t count_ = 0;
};

TEST_F(CloudOutputs, APathInSpaceAndAMapOfPointsComeOut) {
  import("in", "--odometry " + at("in_odometry.txt"));
  const auto summary = summary_of(at("in.rawlog") + truth_of("in"));
  EXPECT_EQ(summary["status"], "ok") << summary["message"];
  EXPECT_EQ(summary["plugins"]["clouds"], count_);
  EXPECT_EQ(summary["plugins"]["clouds_lost"], 0);
  EXPECT_LT(error_of(summary), 0.05);
  const std::string path = read("out/trajectory.tum");
  EXPECT_EQ(std::count(path.begin(), path.end(), '\n'), static_cast<long>(count_) + 1) << "a title";
  const std::string ply = read("out/cloud.ply");
  EXPECT_EQ(ply.substr(0, 36), "ply\nformat binary_little_endian 1.0\n");
  EXPECT_GT(ply.size(), 100'000U);
  EXPECT_NE(read("out/cloud.pcd").find("FIELDS x y z normal_x"), std::string::npos);
  mrpt::maps::CSimpleMap simple;
  ASSERT_TRUE(simple.loadFromFile(at("out/map.simplemap")));
  ASSERT_EQ(simple.size(), summary["plugins"]["cloud_maps"].get<std::size_t>());
  mrpt::poses::CPose3DPDF::Ptr pose;
  mrpt::obs::CSensoryFrame::Ptr frame;
  simple.get(0, pose, frame);
  const auto cloud = frame->getObservationByClass<mrpt::obs::CObservationPointCloud>();
  ASSERT_TRUE(cloud);
  EXPECT_GT(cloud->pointcloud->size(), 1000U);
}

TEST_F(CloudOutputs, WithoutOdometryThePathIsByTheCloudsAlone) {
  import("in", "");
  const auto summary = summary_of(at("in.rawlog") + truth_of("in"));
  EXPECT_EQ(summary["status"], "ok") << summary["message"];
  EXPECT_LT(error_of(summary), 0.1);
}

TEST_F(CloudOutputs, OdometryOfAnotherDriveIsNoNoise) {
  std::istringstream rows(read("in_odometry.txt"));
  std::vector<std::string> times, poses;
  for (std::string row; std::getline(rows, row);) {
    if (row.empty() || row[0] == '#') continue;
    times.push_back(row.substr(0, row.find(' ')));
    poses.push_back(row.substr(row.find(' ')));
  }
  std::string backwards;
  for (std::size_t i = 0; i < times.size(); ++i) {
    backwards += times[i] + poses[times.size() - 1 - i] + "\n";
  }
  write("backwards.txt", backwards);
  import("in", "--odometry " + at("backwards.txt"));
  const auto summary = summary_of(at("in.rawlog") + truth_of("in"));
  const auto& health = summary["health"];
  const auto entry = std::find_if(health.begin(), health.end(), [](const auto& check) {
    return check["name"] == "path against odometry";
  });
  ASSERT_NE(entry, health.end());
  EXPECT_EQ((*entry)["verdict"], "bad") << *entry;
}

TEST_F(CloudOutputs, CloudsAloneAreNoMapWhereTheyAgreeWithNothing) {
  for (std::size_t i = 0; i < count_; ++i) write(fmt::format("in/{}.bin", i), "");
  const Ran ran = run_app("hybrid-import clouds " + at("in") + " -o " + at("in.rawlog"));
  ASSERT_EQ(ran.code, 0) << ran.text;
  const auto summary = summary_of(at("in.rawlog"), 2);
  EXPECT_EQ(summary["status"], "empty") << summary.dump();
  const std::string none =
      fmt::format("nothing was mapped: of {0} clouds {0} show no surface", count_);
  EXPECT_EQ(summary["message"].get<std::string>().find(none), 0U) << summary["message"];
  EXPECT_EQ(entry(summary, "clouds that see nothing").at("verdict"), "bad");
}

TEST_F(CloudOutputs, CloudsWithoutAPointSeeNothing) {
  for (std::size_t i = 1; i < count_; i += 2) write(fmt::format("in/{}.bin", i), "");
  import("in", "--odometry " + at("in_odometry.txt"));
  const auto summary = summary_of(at("in.rawlog"));
  EXPECT_EQ(summary["plugins"]["clouds"], count_);
  EXPECT_EQ(summary["plugins"]["clouds_blind"], count_ / 2);
  const auto found = entry(summary, "clouds that see nothing");
  EXPECT_NEAR(found.at("value"), 0.5, 0.05);
  EXPECT_NE(found.at("verdict"), "good");
}

}  // namespace
}  // namespace hybrid
