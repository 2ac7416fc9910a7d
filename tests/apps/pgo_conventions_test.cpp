// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>

#include "libhybrid/geometry/se2.h"
#include "tests/apps/run_app.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

using PgoConventions = ScratchFolder;

TEST_F(PgoConventions, IdsOfGtsamComeOutAsTheyWentIn) {
  // Three laps, written from each pose back to the one before; false closures besides.
  const std::uint64_t a0 = std::uint64_t{'a'} << 56;
  const auto truth = [](int k) { return SE2(k % 2, 0.2 * (k % 3), 0.3 * k); };
  const auto line = [&](int i, int j, const SE2& z) {
    std::ostringstream text;
    text << "EDGE_SE2 " << a0 + std::uint64_t(3 * i) << ' ' << a0 + std::uint64_t(3 * j) << ' '
         << z.x() << ' ' << z.y() << ' ' << z.angle() << " 400 0 0 400 0 2500\n";
    return text.str();
  };
  std::string text;
  for (int k = 1; k < 24; ++k) text += line(k, k - 1, truth(k).inverse() * truth(k - 1));
  for (int k = 8; k < 24; ++k) text += line(k - 8, k, truth(k - 8).inverse() * truth(k));
  for (int k = 3; k < 8; ++k) text += line(k, k + 12, SE2(k, -k, 1));
  write("ids.g2o", text);
  for (const std::string mode : {"", "--online --trusted odometry "}) {
    const Ran ran =
        run_app("hybrid-pgo " + mode + at("ids.g2o") + " --no-pictures -o " + at("ids"));
    ASSERT_EQ(ran.code, 0) << ran.text;
    const nlohmann::json result = nlohmann::json::parse(read("ids/summary.json"));
    EXPECT_EQ(result.at("inliers"), 16) << mode;
    EXPECT_EQ(result.at("outliers"), 5) << mode;
    EXPECT_NEAR(result.at("cost").get<double>(), 0.0, 1e-6) << mode;
    EXPECT_NE(read("ids/loops.csv").find("\n6989586621679009792,6989586621679009816,accepted"),
              std::string::npos);
    EXPECT_NE(read("ids/trajectory.tum").find("\n6989586621679009795 "), std::string::npos);
    if (mode.empty()) continue;
    EXPECT_NE(read("ids/steps.csv").find("\n6989586621679009795,"), std::string::npos);
    EXPECT_NE(read("ids/graph.g2o").find("EDGE_SE2 6989586621679009795 6989586621679009792 "),
              std::string::npos);
  }
}

/// Noise of odometry four times what is stated, of closures as stated; the same with all stated
/// right.
TEST_F(PgoConventions, NoiseIsMeasuredByKind) {
  const auto truth = [](int k) { return SE2(k % 2, 0.2 * (k % 3), 0.3 * k); };
  for (const double factor : {1.0, 4.0}) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::ostringstream text;
    const auto line = [&](int i, int j, double noise) {
      const double x = normal(random), y = normal(random), yaw = normal(random);
      const SE2 z = truth(i).inverse() * truth(j) *
                    SE2(0.05 * noise * x, 0.05 * noise * y, 0.02 * noise * yaw);
      text << "EDGE_SE2 " << i << ' ' << j << ' ' << z.x() << ' ' << z.y() << ' ' << z.angle()
           << " 400 0 0 400 0 2500\n";
    };
    for (int k = 1; k < 200; ++k) {
      line(k - 1, k, factor);
      if (k >= 8) line(k - 8, k, 1.0);
    }
    write("noise.g2o", text.str());
    const Ran ran =
        run_app("hybrid-pgo --method lm " + at("noise.g2o") + " --no-pictures -o " + at("noise"));
    ASSERT_EQ(ran.code, 0) << ran.text;
    const nlohmann::json result = nlohmann::json::parse(read("noise/summary.json"));
    ASSERT_EQ(result.at("noise").size(), 3u);
    const auto& odometry = result["noise"][0];
    EXPECT_EQ(odometry.at("kind"), "odometry");
    EXPECT_NEAR(odometry.at("measured").get<double>(), factor,
                4 * odometry.at("sigma").get<double>());
    EXPECT_LT(odometry.at("sigma").get<double>(), 0.1 * factor);
    EXPECT_EQ(result["noise"][1].at("kind"), "closures");
    EXPECT_NEAR(result["noise"][1].at("measured").get<double>(), 1, 0.2);
    EXPECT_TRUE(result["noise"][2].at("measured").is_null()) << "a prior that nothing checks";
    EXPECT_EQ(ran.text.find("noise of odometry") != std::string::npos, factor > 2) << ran.text;
  }
}

}  // namespace
}  // namespace hybrid
