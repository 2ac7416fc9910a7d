// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "tests/apps/replay_runner.h"
#include "tests/support/cloud_worlds.h"

namespace hybrid {
namespace {

/// A lidar that is carried once around a hall and a quarter more, with odometry whose heading
/// drifts.
class CloudOutputs : public ReplayTest {
 protected:
  void SetUp() override {
    ReplayTest::SetUp();
    std::filesystem::create_directories(at("clouds"));
    const std::vector<SE3> way = testing::way_around_hall(0.5);
    std::mt19937 random(4);
    std::string truth, odometry;
    SE3 by_odometry = way[0];
    for (std::size_t i = 0; i < way.size(); ++i) {
      if (i > 0) {
        by_odometry = by_odometry * way[i - 1].between(way[i]) *
                      SE3(Eigen::Vector3d(0.02, 0, 0), SO3::exp(Eigen::Vector3d(0, 0, 0.01)));
      }
      truth += row(i, way[i]);
      odometry += row(i, by_odometry);
      std::string bytes;
      for (const Eigen::Vector3f& p :
           testing::cloud_at(testing::cluttered_hall(), way[i], random)) {
        const float values[4] = {p.x(), p.y(), p.z(), 0};
        bytes.append(reinterpret_cast<const char*>(values), sizeof values);
      }
      write(fmt::format("clouds/{}.bin", i), bytes);
    }
    write("truth.txt", truth);
    write("odometry.txt", odometry);
    count_ = way.size();
  }
  void import(const std::string& options) const {
    const Ran ran = run_app("hybrid-import clouds " + at("clouds") + " " + options + " --truth " +
                            at("truth.txt") + " -o " + at("in.rawlog"));
    ASSERT_EQ(ran.code, 0) << ran.text;
  }
  static double error_of(const nlohmann::json& summary) {
    return summary["truth"]["trajectory"]["rmse_m"];
  }
  std::size_t count_ = 0;

 private:
  static std::string row(std::size_t i, const SE3& pose) {
    const Eigen::Vector3d& t = pose.translation();
    const Eigen::Quaterniond& q = pose.rotation().quaternion();
    return fmt::format("{} {} {} {} {} {} {} {}\n", 0.5 * static_cast<double>(i), t.x(), t.y(),
                       t.z(), q.x(), q.y(), q.z(), q.w());
  }
};

TEST_F(CloudOutputs, APathInSpaceAndAMapOfPointsComeOut) {
  import("--odometry " + at("odometry.txt"));
  const auto summary =
      summary_of(at("in.rawlog") + " --truth-path " + at("in_ground_truth_robot_path.txt"));
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
}

TEST_F(CloudOutputs, WithoutOdometryThePathIsByTheCloudsAlone) {
  import("");
  const auto summary =
      summary_of(at("in.rawlog") + " --truth-path " + at("in_ground_truth_robot_path.txt"));
  EXPECT_EQ(summary["status"], "ok") << summary["message"];
  EXPECT_LT(error_of(summary), 0.1);
}

TEST_F(CloudOutputs, CloudsAloneAreNoMapWhereTheyAgreeWithNothing) {
  const auto clouds = std::filesystem::path(at("clouds"));
  for (std::size_t i = 0; i < count_; ++i) write(fmt::format("clouds/{}.bin", i), "");
  const Ran ran = run_app("hybrid-import clouds " + at("clouds") + " -o " + at("in.rawlog"));
  ASSERT_EQ(ran.code, 0) << ran.text;
  const auto summary = summary_of(at("in.rawlog"), 2);
  EXPECT_EQ(summary["status"], "empty") << summary.dump();
}

}  // namespace
}  // namespace hybrid
