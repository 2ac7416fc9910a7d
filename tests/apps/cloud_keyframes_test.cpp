// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <string>

#include "libhybrid/geometry/isometry.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "tests/apps/cloud_log.h"

namespace hybrid {
namespace {

/// Keyframes of other systems: clouds with poses that drift, and closures.
class CloudKeyframes : public CloudLogTest {
 protected:
  void SetUp() override {
    CloudLogTest::SetUp();
    way_ = testing::way_around_hall(0.5);
    drifting_ = {way_[0]};
    for (std::size_t i = 1; i < way_.size(); ++i) {
      drifting_.push_back(drifting_.back() * way_[i - 1].between(way_[i]) *
                          SE3(Eigen::Vector3d(0.02, 0, 0), SO3::exp(Eigen::Vector3d(0, 0, 0.01))));
    }
  }
  static std::string edge(std::size_t from, std::size_t to, const SE3& motion) {
    const Eigen::Vector3d& t = motion.translation();
    const Eigen::Quaterniond& q = motion.rotation().quaternion();
    return fmt::format(
        "EDGE_SE3:QUAT {} {} {} {} {} {} {} {} {} 100 0 0 0 0 0 100 0 0 0 0 100 0 0 0 400 0 0 400 "
        "0 "
        "400\n",
        from, to, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  }
  std::vector<SE3> way_, drifting_;
};

TEST_F(CloudKeyframes, ASimpleMapIsMappedAsALog) {
  mrpt::maps::CSimpleMap map;
  std::mt19937 random(4);
  std::string truth;
  for (std::size_t i = 0; i < way_.size(); ++i) {
    const auto points = mrpt::maps::CSimplePointsMap::Create();
    for (const auto& p : testing::cloud_at(testing::cluttered_hall(), way_[i], random)) {
      points->insertPoint(p.x(), p.y(), p.z());
    }
    const auto seen = mrpt::obs::CObservationPointCloud::Create();
    seen->timestamp = mrpt::Clock::fromDouble(1e9 + 0.5 * double(i));
    seen->pointcloud = points;
    const auto frame = mrpt::obs::CSensoryFrame::Create();
    frame->insert(seen);
    const auto pose = mrpt::poses::CPose3DPDFGaussian::Create();
    pose->mean = to_mrpt(to_isometry(drifting_[i]));
    map.insert(mrpt::poses::CPose3DPDF::Ptr(pose), frame);
    truth += row(1e9 + 0.5 * double(i), way_[i]);
  }
  ASSERT_TRUE(map.saveToFile(at("in.simplemap")));
  write("truth.tum", truth);
  const auto summary = summary_of(at("in.simplemap") + " --truth-path " + at("truth.tum"));
  EXPECT_EQ(summary["status"], "ok") << summary["message"];
  EXPECT_EQ(summary["plugins"]["clouds"], way_.size());
  EXPECT_LT(summary["truth"]["trajectory"]["rmse_m"].get<double>(), 0.05);
}

// A driver that has no new cloud may send the last one again.
TEST_F(CloudKeyframes, CloudsThatComeAgainAreLeftOut) {
  write_clouds("in", testing::cluttered_hall(), way_, 4);
  for (std::size_t i = 1; i < way_.size(); i += 3) {
    write(fmt::format("in/{}.bin", i), read(fmt::format("in/{}.bin", i - 1)));
  }
  import("in", "--odometry " + at("in_odometry.txt"));
  const auto summary = summary_of(at("in.rawlog") + truth_of("in"));
  EXPECT_EQ(summary["dropped"]["cloud dropped: it is the one before once more, point by point"],
            (way_.size() + 1) / 3);
  EXPECT_EQ(summary["plugins"]["clouds_lost"], 0);
  EXPECT_LT(summary["truth"]["trajectory"]["aligned"]["rmse_m"].get<double>(), 0.05);
}

TEST_F(CloudKeyframes, ClosuresOfAGraphAreTriedAsOthersAre) {
  write_clouds("in", testing::cluttered_hall(), way_, 4);
  std::string graph;
  for (std::size_t i = 1; i < way_.size(); ++i) {
    graph += edge(100 + i - 1, 100 + i, drifting_[i - 1].between(drifting_[i]));
  }
  const std::size_t last = way_.size() - 1;
  graph += edge(102, 100 + last - 13, way_[2].between(way_[last - 13]));
  graph += edge(100 + last - 2, 105, SE3({4, 4, 0}, SO3()));  // false
  graph += edge(110, 112, way_[10].between(way_[12]));        // within a local map
  write("graph.g2o", graph);
  import("in", "--odometry " + at("graph.g2o"));
  const auto summary = summary_of(at("in.rawlog") + truth_of("in") +
                                  " --set PointClouds.map_length=1 --set PointClouds.closures=no "
                                  "--set PointClouds.candidates=" +
                                  at("graph.g2o"));
  EXPECT_EQ(summary["status"], "ok") << summary["message"];
  EXPECT_GE(summary["plugins"]["cloud_closures"], 1);
  EXPECT_EQ(summary["plugins"]["cloud_closures_accepted"], 1);
  EXPECT_EQ(summary["plugins"]["cloud_candidates"], 3);
  EXPECT_EQ(summary["plugins"]["cloud_candidates_not_tried"], 1);
  EXPECT_EQ(
      summary["dropped"]["candidate not tried: one local map has both clouds, or two that overlap"],
      1)
      << summary["dropped"];
  EXPECT_NE(read("out/cloud_loops.csv").find(fmt::format("\n2,{},accepted", last - 13)),
            std::string::npos);
  EXPECT_LT(summary["truth"]["trajectory"]["rmse_m"].get<double>(), 0.1);
}

}  // namespace
}  // namespace hybrid
