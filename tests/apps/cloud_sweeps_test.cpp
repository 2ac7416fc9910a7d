// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <string>

#include "tests/apps/replay_runner.h"
#include "tests/support/cloud_worlds.h"

namespace hybrid {
namespace {

constexpr double kBetweenSweeps = 0.5;  // s
constexpr std::size_t kClouds = 60;

/// A lidar that is carried around a hall at 1 m/s, faster and slower, and needs 0.3 s for a sweep.
/// Without odometry it starts slowly.
class CloudSweeps : public ReplayTest {
 protected:
  static SE3 place(double time, bool with_odometry) {
    const double behind = with_odometry ? 0 : 1 - std::exp(-time);
    return testing::place_around_hall((time + 0.2 * std::sin(time) - behind) / 5);
  }
  /// Makes NAME.rawlog, of clouds with times where `has_times` says so.
  void make(const std::string& name, bool with_odometry,
            const std::function<bool(std::size_t)>& has_times) const {
    std::filesystem::create_directories(at(name));
    const auto place_at = [&](double time) { return place(time, with_odometry); };
    std::mt19937 random(4);
    std::string truth, odometry;
    SE3 by_odometry = place_at(0);
    for (std::size_t i = 0; i < kClouds; ++i) {
      const double time = kBetweenSweeps * static_cast<double>(i);
      if (i > 0) {
        by_odometry = by_odometry * place_at(time - kBetweenSweeps).between(place_at(time)) *
                      SE3(Eigen::Vector3d(0.02, 0, 0), SO3::exp(Eigen::Vector3d(0, 0, 0.01)));
      }
      truth += row(time, place_at(time));
      odometry += row(time, by_odometry);
      const testing::Sweep sweep = testing::sweep_at(
          testing::cluttered_hall(), [&](double after) { return place_at(time + after); }, 0.3,
          random);
      write(fmt::format("{}/{}.pcd", name, i), pcd(sweep, has_times(i)));
    }
    write(name + ".truth", truth);
    write(name + ".odometry", odometry);
    const Ran ran = run_app("hybrid-import clouds " + at(name) + " --truth " + at(name + ".truth") +
                            (with_odometry ? " --odometry " + at(name + ".odometry") : "") +
                            " -o " + at(name + ".rawlog"));
    ASSERT_EQ(ran.code, 0) << ran.text;
  }
  /// The root mean square error of the path [m].
  double error_of(const std::string& name, bool with_odometry,
                  const std::function<bool(std::size_t)>& has_times) const {
    make(name, with_odometry, has_times);
    const auto summary = summary_of(at(name + ".rawlog") + " --truth-path " +
                                    at(name + "_ground_truth_robot_path.txt"));
    EXPECT_EQ(summary["status"], "ok") << summary["message"];
    EXPECT_EQ(summary["plugins"]["clouds"], kClouds);
    const double error = summary["truth"]["trajectory"]["rmse_m"];
    std::printf("%s times, %s odometry: %.4f m\n", name.c_str(), with_odometry ? "with" : "without",
                error);
    return error;
  }

 private:
  static std::string row(double time, const SE3& pose) {
    const Eigen::Vector3d& t = pose.translation();
    const Eigen::Quaterniond& q = pose.rotation().quaternion();
    return fmt::format("{} {} {} {} {} {} {} {}\n", time, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(),
                       q.w());
  }
  static std::string pcd(const testing::Sweep& sweep, bool has_times) {
    std::string out = fmt::format(
        "VERSION 0.7\nFIELDS x y z {}\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {}\nHEIGHT "
        "1\nPOINTS {}\nDATA binary\n",
        has_times ? "t" : "intensity", sweep.points.size(), sweep.points.size());
    for (std::size_t i = 0; i < sweep.points.size(); ++i) {
      const Eigen::Vector3f& p = sweep.points[i];
      const float values[4] = {p.x(), p.y(), p.z(), sweep.times[i]};
      out.append(reinterpret_cast<const char*>(values), sizeof values);
    }
    return out;
  }
};

const auto kAll = [](std::size_t) { return true; };
const auto kNone = [](std::size_t) { return false; };
const auto kMixed = [](std::size_t i) { return i % 5 != 2; };

TEST_F(CloudSweeps, TimesOfPointsMakeThePathBetter) {
  for (const bool with_odometry : {true, false}) {
    const double with = error_of("with", with_odometry, kAll);
    const double without = error_of("without", with_odometry, kNone);
    EXPECT_LT(with, 0.5 * without) << with_odometry;
  }
}

TEST_F(CloudSweeps, SomeCloudsMayHaveNoTimesAndThePathIsTheSameEachTime) {
  const double without = error_of("without", true, kNone);
  EXPECT_LT(error_of("a", true, kMixed), without);
  const std::string first = read("out/trajectory.tum");
  error_of("b", true, kMixed);
  EXPECT_EQ(read("out/trajectory.tum"), first);
}

}  // namespace
}  // namespace hybrid
