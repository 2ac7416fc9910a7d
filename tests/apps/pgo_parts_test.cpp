// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "libhybrid/geometry/se2.h"
#include "tests/apps/run_app.h"
#include "tests/support/random.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

using testing::Random;

/// Graphs of robots that drive the same circle, as text.
class PgoParts : public ScratchFolder {
 protected:
  /// The pose of a robot on its way; another begins elsewhere.
  static SE2 truth(int robot, int k) {
    const double angle = (k + 9 * robot) * 2.0 * M_PI / 40;
    return {5 * std::cos(angle), 5 * std::sin(angle), angle + M_PI / 2};
  }
  /// GTSAM's Symbol a0, a1, ..., b0, ...
  static std::uint64_t symbol(int robot, int k) {
    return (std::uint64_t('a' + robot) << 56) + std::uint64_t(k);
  }
  SE2 noisy(const SE2& z) {
    const double x = random.normal(0.02), y = random.normal(0.02);
    return z * SE2(x, y, random.normal(0.01));
  }
  static std::string numbers(const SE2& z) {
    std::ostringstream text;
    text.precision(15);
    text << ' ' << z.x() << ' ' << z.y() << ' ' << z.angle();
    return text.str();
  }
  static std::string edge(std::uint64_t i, std::uint64_t j, const SE2& z) {
    return "EDGE_SE2 " + std::to_string(i) + ' ' + std::to_string(j) + numbers(z) +
           " 2500 0 0 2500 0 10000\n";
  }
  std::string odometry(int robot, int poses) {
    std::string text;
    for (int k = 1; k < poses; ++k) {
      text += edge(symbol(robot, k - 1), symbol(robot, k),
                   noisy(truth(robot, k - 1).between(truth(robot, k))));
    }
    return text;
  }
  nlohmann::json solved(const std::string& options) {
    const Ran ran = run_app("hybrid-pgo " + options + " --no-pictures -o " + at("out"));
    EXPECT_EQ(ran.code, 0) << ran.text;
    said = ran.text;
    return nlohmann::json::parse(read("out/summary.json"));
  }

  Random random{5};
  std::string said;
};

TEST_F(PgoParts, TwoRobotsMeetWhereTheirClosuresAgree) {
  std::string text = odometry(0, 60) + odometry(1, 60), labels;
  for (int i = 0; i < 24; ++i) {
    const int a = random.below(60), b = random.below(60);
    const bool is_true = i >= 12;  // the false ones first
    const SE2 z = is_true ? noisy(truth(0, a).between(truth(1, b)))
                          : SE2(random.uniform(-6, 6), 1, random.uniform(-3, 3));
    text += edge(symbol(0, a), symbol(1, b), z);
    const std::string pair = std::to_string(symbol(0, a)) + ' ' + std::to_string(symbol(1, b));
    if (is_true) labels += pair + '\n';
  }
  const std::string graph = write("two.g2o", text);
  const std::string with_labels = " --labels " + write("true.txt", labels);
  for (const std::string mode : {"", " --online --trusted odometry"}) {
    const nlohmann::json result = solved(graph + with_labels + mode);
    EXPECT_EQ(result.at("inliers"), 12) << mode;
    EXPECT_EQ(result.at("truth").at("loop_precision"), 1.0) << mode;
    EXPECT_GT(result.at("truth").at("loop_recall"), 0.9) << mode;
    EXPECT_NE(result.at("health").dump().find("joined by closures that agree"), std::string::npos);
  }
}

TEST_F(PgoParts, WhatNothingSupportsIsBadAndNamedAsInTheFile) {
  std::string text = odometry(0, 20) + odometry(1, 20);
  for (const int k : {3, 8, 15}) {
    text += edge(symbol(0, k), symbol(1, 19 - k), SE2(k, -k, 0.3 * k));
  }
  const std::string graph = write("apart.g2o", text);
  solved(graph);
  EXPECT_NE(said.find("parts of the trajectory: Of 2 parts"), std::string::npos) << said;
  // Neither robot can be reached from the other.
  const std::string two = write("two.g2o", odometry(0, 5) + odometry(1, 5));
  const Ran ran = run_app("hybrid-pgo " + two + " -o " + at("none"));
  EXPECT_EQ(ran.code, 1);
  EXPECT_NE(ran.text.find("vertex b0, b1, b2, b3, b4 to vertex a0"), std::string::npos) << ran.text;
}

TEST_F(PgoParts, PartsThatAreMeasuredInTheMapHaveItsFrame) {
  const std::string first = "EDGE_PRIOR_SE2 " + std::to_string(symbol(0, 0)) +
                            numbers(truth(0, 0)) + " 2500 0 0 2500 0 10000\n";
  std::string positions;
  for (const int k : {4, 18, 30}) {
    std::ostringstream line;
    line << "EDGE_PRIOR_SE2_XY " << symbol(1, k) << ' ' << truth(1, k).x() << ' ' << truth(1, k).y()
         << " 400 0 400\n";
    positions += line.str();
  }
  const std::string graph = write("map.g2o", first + odometry(0, 40) + positions + odometry(1, 40));
  std::string poses;
  for (const int robot : {0, 1}) {
    for (int k = 0; k < 40; ++k) {
      poses += "VERTEX_SE2 " + std::to_string(symbol(robot, k)) + numbers(truth(robot, k)) + '\n';
    }
  }
  const std::string true_poses = " --truth " + write("truth.g2o", poses);
  double cost = -1;
  for (const std::string mode : {" --method lm", "", " --online", " --online --trusted odometry"}) {
    const nlohmann::json result = solved(graph + true_poses + mode);
    if (cost < 0) cost = result.at("cost");
    EXPECT_NEAR(result.at("cost"), cost, 1e-4) << mode;
    EXPECT_LT(cost, 5.0);
    EXPECT_LT(result.at("truth").at("trajectory").at("rmse_m"), 1.0) << mode;
  }
}

TEST_F(PgoParts, ErrorsDoNotDependOnWhereTheMapBegins) {
  const SE2 utm(5000, 46000, 1);
  std::string poses, vertices;
  for (int k = 0; k < 40; ++k) {
    const std::string id = std::to_string(symbol(0, k));
    poses += "VERTEX_SE2 " + id + numbers(utm * truth(0, k)) + '\n';
    vertices += "VERTEX_SE2 " + id + numbers(SE2(k, 0, 0)) + '\n';
  }
  const std::string prior = "EDGE_PRIOR_SE2 " + std::to_string(symbol(0, 0)) +
                            numbers(utm * truth(0, 0)) + " 2500 0 0 2500 0 10000\n";
  const std::string edges = prior + odometry(0, 40);
  const std::string true_poses = " --method lm --truth " + write("truth.g2o", poses);
  const auto rmse = [&](const std::string& graph) -> double {
    return solved(graph + true_poses)["truth"]["trajectory"]["rmse_m"];
  };
  const double without = rmse(write("edges.g2o", edges));
  EXPECT_LT(without, 1.0);
  EXPECT_NEAR(rmse(write("vertices.g2o", vertices + edges)), without, 1e-4);
}

TEST_F(PgoParts, SaysWhatIsDoubtfulInTheFile) {
  std::string text = odometry(0, 60);
  for (int k = 0; k < 3; ++k) text += edge(symbol(0, 7), symbol(0, 50), SE2(3, 4, 1));
  solved(write("copies.g2o", text));
  EXPECT_NE(said.find("2 edges are the same as one before"), std::string::npos) << said;
  std::string inverted;
  std::istringstream lines(odometry(0, 60));
  for (std::string line; std::getline(lines, line);) {
    inverted += line.substr(0, line.find(" 2500 ")) + " 0.0004 0 0 0.0004 0 0.0001\n";
  }
  solved(write("inverted.g2o", inverted));
  EXPECT_NE(said.find("Is the information a covariance?"), std::string::npos) << said;
}

}  // namespace
}  // namespace hybrid
