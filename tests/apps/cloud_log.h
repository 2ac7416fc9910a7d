// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <fmt/format.h>

#include <random>
#include <string>
#include <vector>

#include "tests/apps/replay_runner.h"
#include "tests/support/cloud_worlds.h"

namespace hybrid {

/// Logs of a lidar that is carried through a world, with odometry whose heading drifts.
class CloudLogTest : public ReplayTest {
 protected:
  /// Files in the folder NAME, with NAME_truth.txt and NAME_odometry.txt.
  void write_clouds(const std::string& name, const testing::CloudWorld& world,
                    const std::vector<SE3>& way, unsigned seed, double begin = 0) const {
    std::filesystem::create_directories(at(name));
    std::mt19937 random(seed);
    std::string truth, odometry;
    SE3 by_odometry = way[0];
    for (std::size_t i = 0; i < way.size(); ++i) {
      if (i > 0) {
        by_odometry = by_odometry * way[i - 1].between(way[i]) *
                      SE3(Eigen::Vector3d(0.02, 0, 0), SO3::exp(Eigen::Vector3d(0, 0, 0.01)));
      }
      const double time = begin + 0.5 * static_cast<double>(i);
      truth += row(time, way[i]);
      odometry += row(time, by_odometry);
      std::string bytes;
      for (const Eigen::Vector3f& p : testing::cloud_at(world, way[i], random)) {
        const float values[4] = {p.x(), p.y(), p.z(), 0};
        bytes.append(reinterpret_cast<const char*>(values), sizeof values);
      }
      write(fmt::format("{}/{}.bin", name, i), bytes);
    }
    write(name + "_truth.txt", truth);
    write(name + "_odometry.txt", odometry);
  }
  /// Makes NAME.rawlog of them.
  void import(const std::string& name, const std::string& options) const {
    const Ran ran = run_app("hybrid-import clouds " + at(name) + " " + options + " --truth " +
                            at(name + "_truth.txt") + " -o " + at(name + ".rawlog"));
    ASSERT_EQ(ran.code, 0) << ran.text;
  }
  std::string truth_of(const std::string& name) const {
    return " --truth-path " + at(name + "_ground_truth_robot_path.txt");
  }
  static std::string row(double time, const SE3& pose) {
    const Eigen::Vector3d& t = pose.translation();
    const Eigen::Quaterniond& q = pose.rotation().quaternion();
    return fmt::format("{} {} {} {} {} {} {} {}\n", time, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(),
                       q.w());
  }
};

}  // namespace hybrid
