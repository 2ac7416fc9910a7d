// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <array>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "libhybrid/core/infinity.h"
#include "tests/apps/replay_runner.h"

namespace hybrid {

/// Keyframes of the log before the second part.
inline constexpr std::size_t kBeforeSecond = 110;

/// MRPT's demonstration log without ids, whole and in two parts that overlap.
class MapTest : public ReplayTest {
 protected:
  void SetUp() override {
    write("a.ini",
          "[log]\nrawlog = /usr/share/mrpt/datasets/kf-slam_demo.rawlog\n"
          "[odometry]\nsigmas = 0.04 0.04 0.000175\n"
          "[sensor]\nsigma_range = 0.01\nsigma_yaw_deg = 0.1\nids = none\n"
          "[plugins]\nclasses = BearingRangeAssociation\n");
  }
  void cut(const std::string& name, const std::string& range) const {
    const Ran ran =
        run_shell("rawlog-edit --cut -w " + range +
                  " -i /usr/share/mrpt/datasets/kf-slam_demo.rawlog -o " + at(name) + " 2>&1");
    ASSERT_EQ(ran.code, 0) << ran.text;
  }
  void cut_in_two() const {
    cut("first.rawlog", "--to-index 299");
    cut("second.rawlog", "--from-index 220");
  }
  /// A replay of a log of the folder with a map of the folder, into the folder `out`.
  std::string replay_of(const std::string& log, const std::string& map,
                        const std::string& out) const {
    return "-c " + at("a.ini") + (log.empty() ? "" : " --rawlog " + at(log)) + " --no-pictures" +
           (map.empty() ? "" : " --map " + at(map)) + " -o " + at(out);
  }
  nlohmann::json summary_in(const std::string& out) const {
    return nlohmann::json::parse(read(out + "/summary.json"));
  }
  nlohmann::json info_of(const std::string& map) const {
    const Ran ran = run_app("hybrid-map info --json " + at(map));
    EXPECT_EQ(ran.code, 0) << ran.text;
    return nlohmann::json::parse(ran.text, nullptr, false);
  }
  /// Expects a failure with one line that names the map and says `part`, the map left as it was.
  void expect_refusal(const std::string& command, const std::string& map,
                      const std::string& part) const {
    const std::string before = read(map);
    const Ran ran = run_app(command);
    EXPECT_EQ(ran.code, 1) << command << "\n" << ran.text;
    EXPECT_NE(ran.text.find(part), std::string::npos) << ran.text;
    EXPECT_NE(ran.text.find(map), std::string::npos) << ran.text;
    EXPECT_EQ(ran.text.find('\n'), ran.text.size() - 1) << ran.text;
    EXPECT_EQ(read(map), before);
  }
  /// Root mean square distance of the positions of two trajectories, of which b has some more at
  /// its beginning; infinity where it has no more than these.
  double distance(const std::string& a, const std::string& b, std::size_t more = 0) const {
    const auto positions = [this](const std::string& name) {
      std::vector<std::array<double, 2>> out;
      std::istringstream lines(read(name));
      for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        double time = 0;
        std::array<double, 2> p{};
        if (words >> time >> p[0] >> p[1]) out.push_back(p);
      }
      return out;
    };
    const auto p = positions(a), q = positions(b);
    double sum = 0;
    std::size_t count = 0;
    for (; count < p.size() && count + more < q.size(); ++count) {
      sum += std::pow(p[count][0] - q[count + more][0], 2) +
             std::pow(p[count][1] - q[count + more][1], 2);
    }
    return count == 0 ? kInfinity : std::sqrt(sum / static_cast<double>(count));
  }
};

}  // namespace hybrid
