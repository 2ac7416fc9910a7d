// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
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

}  // namespace
}  // namespace hybrid
