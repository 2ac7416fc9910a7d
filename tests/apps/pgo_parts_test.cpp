// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

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

TEST_F(PgoParts, OdometryThatSaysNothingIsABreak) {
  // One edge of odometry is stated to be unknown; closures hold the rest, two of them are false.
  std::string odometry = this->odometry(0, 80), closures;
  const std::size_t line =
      odometry.find(std::to_string(symbol(0, 50)) + ' ' + std::to_string(symbol(0, 51)));
  const std::size_t begin = odometry.find(" 2500 0 0", line), end = odometry.find('\n', line);
  for (int k = 0; k < 40; ++k) {
    closures += edge(symbol(0, k), symbol(0, k + 40), noisy(truth(0, k).between(truth(0, k + 40))));
  }
  closures = edge(symbol(0, 3), symbol(0, 70), SE2(4, 1, 2)) +
             edge(symbol(0, 30), symbol(0, 60), SE2(-2, 5, 1)) + closures;
  for (const std::string sure :
       {"1e-12 0 0 1e-12 0 1e-12", "1e-300 0 0 1e-300 0 1e-300", "2500 0 0 2500 0 1e-12"}) {
    std::string text = odometry;
    text.replace(begin, end - begin, ' ' + sure);
    for (const std::string mode : {"", " --online --trusted odometry", " --method portfolio"}) {
      const nlohmann::json result = solved(write("break.g2o", text + closures) + mode);
      EXPECT_EQ(result.at("outliers"), 2) << sure << mode;
      EXPECT_NE(said.find("1 edges of odometry say nothing, as a50 a51"), std::string::npos)
          << said;
      // Where nothing else holds both parts together, it does.
      const nlohmann::json alone = solved(write("alone.g2o", text) + mode);
      EXPECT_NEAR(alone.at("cost").get<double>(), 0.0, 1e-6) << sure << mode;
    }
  }
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

/// Graphs with positions and poses measured in the map, some of which are false.
class PgoInMap : public PgoParts {
 protected:
  /// A position of every third pose from `first` on; `wrong` of them are 50 m off.
  std::string positions(int robot, int poses, int first, int wrong, const SE2& origin = SE2()) {
    std::ostringstream text;
    text.precision(15);
    int count = 0;
    for (int k = first; k < poses; k += 3, ++count) {
      const bool is_false = count % 4 == 2 && count / 4 < wrong;
      const double off = is_false ? 50 : 0, way = random.uniform(-3, 3);
      const double x = random.normal(0.1), y = random.normal(0.1);
      const SE2 at = origin * truth(robot, k);
      text << "EDGE_PRIOR_SE2_XY " << symbol(robot, k) << ' ' << at.x() + x + off * std::cos(way)
           << ' ' << at.y() + y + off * std::sin(way) << " 100 0 100\n";
      if (is_false) false_ones.insert(symbol(robot, k));
    }
    return text.str();
  }
  std::string true_poses(int robots, int poses, const SE2& origin = SE2()) {
    std::string text;
    for (int robot = 0; robot < robots; ++robot) {
      for (int k = 0; k < poses; ++k) {
        text += "VERTEX_SE2 " + std::to_string(symbol(robot, k)) +
                numbers(origin * truth(robot, k)) + '\n';
      }
    }
    return " --truth " + write("truth.g2o", text);
  }
  /// The poses in loops.csv whose measurement in the map was rejected.
  std::set<std::uint64_t> rejected() {
    std::set<std::uint64_t> poses;
    std::istringstream rows(read("out/loops.csv"));
    for (std::string row; std::getline(rows, row);) {
      const std::size_t j = row.find(',') + 1, decision = row.find(',', j) + 1;
      if (decision == 0 || row.substr(0, j - 1) != row.substr(j, decision - j - 1)) continue;
      if (row.compare(decision, 8, "rejected") == 0) poses.insert(std::stoull(row));
    }
    return poses;
  }

  std::set<std::uint64_t> false_ones;
};

TEST_F(PgoInMap, FalsePositionsAreFoundAsFalseClosuresAre) {
  const std::string graph = write("g.g2o", odometry(0, 80) + positions(0, 80, 0, 5));
  const std::string truth = true_poses(1, 80);
  for (const std::string mode : {"", " --online --trusted odometry", " --method portfolio"}) {
    const nlohmann::json result = solved(graph + truth + mode);
    EXPECT_EQ(rejected(), false_ones) << mode;
    EXPECT_EQ(result.at("in_map"), 22) << mode;
    EXPECT_EQ(result.at("in_map_rejected"), 5) << mode;
    EXPECT_EQ(result.at("inliers"), 0) << mode;
    EXPECT_LT(result.at("truth").at("trajectory").at("aligned").at("rmse_m"), 0.2) << mode;
  }
  // Nothing is rejected, and what contradicts itself has no minimum that is worth much.
  run_app("hybrid-pgo " + graph + " --method lm --no-pictures -o " + at("out"));
  EXPECT_EQ(rejected().size(), 0);
}

TEST_F(PgoInMap, FalsePositionsDoNotMoveParts) {
  const std::string graph = write("g.g2o", odometry(0, 60) + positions(0, 60, 5, 4) +
                                               odometry(1, 60) + positions(1, 60, 20, 2));
  const std::string truth = true_poses(2, 60);
  for (const std::string mode : {"", " --online --trusted odometry"}) {
    const nlohmann::json result = solved(graph + truth + mode);
    EXPECT_EQ(rejected(), false_ones) << mode;
    EXPECT_LT(result.at("truth").at("trajectory").at("aligned").at("rmse_m"), 0.3) << mode;
  }
}

TEST_F(PgoInMap, FalsePosesAndClosuresTogether) {
  std::string text = odometry(0, 80), labels;
  for (int k = 0; k < 80; k += 5) {
    const bool is_false = k % 20 == 10;
    text += "EDGE_PRIOR_SE2 " + std::to_string(symbol(0, k)) +
            numbers(is_false ? SE2(k, -k, 1) : noisy(truth(0, k))) + " 2500 0 0 2500 0 10000\n";
    if (is_false) false_ones.insert(symbol(0, k));
  }
  for (int k = 0; k < 30; ++k) {
    const bool is_true = k % 3 > 0;
    text += edge(symbol(0, k), symbol(0, k + 40),
                 is_true ? noisy(truth(0, k).between(truth(0, k + 40))) : SE2(k % 5, 3, k));
    if (is_true) {
      labels += std::to_string(symbol(0, k)) + ' ' + std::to_string(symbol(0, k + 40)) + '\n';
    }
  }
  const std::string options = write("g.g2o", text) + " --labels " + write("true.txt", labels);
  for (const std::string mode : {"", " --online --trusted odometry"}) {
    const nlohmann::json result = solved(options + mode);
    EXPECT_EQ(rejected(), false_ones) << mode;
    EXPECT_EQ(result.at("truth").at("loop_precision"), 1.0) << mode;
    EXPECT_EQ(result.at("truth").at("loop_recall"), 1.0) << mode;
  }
}

TEST_F(PgoInMap, WhatAloneHoldsTheMapIsNotRejected) {
  const std::string prior = "EDGE_PRIOR_SE2 " + std::to_string(symbol(0, 7)) +
                            numbers(SE2(100, 200, 1)) + " 2500 0 0 2500 0 10000\n";
  const std::string graph = write("g.g2o", odometry(0, 60) + prior);
  for (const std::string mode : {"", " --online --trusted odometry"}) {
    const nlohmann::json result = solved(graph + mode);
    EXPECT_EQ(result.at("in_map"), 1) << mode;
    EXPECT_EQ(rejected().size(), 0) << mode;
    EXPECT_LT(result.at("cost"), 1e-9) << mode;
  }
}

TEST_F(PgoInMap, PositionsMayComeLate) {
  const std::string graph = write("g.g2o", odometry(0, 60) + positions(0, 60, 31, 0));
  const double cost = solved(graph + " --method lm").at("cost");
  for (const std::string mode : {"", " --online", " --online --trusted odometry"}) {
    EXPECT_NEAR(solved(graph + mode).at("cost"), cost, 1e-6) << mode;
  }
}

TEST_F(PgoInMap, CoordinatesOfMillionsOfMetresLoseNoDigits) {
  const auto poses = [&](const SE2& origin, const std::string& mode) {
    random = Random(7);
    solved(write("g.g2o", odometry(0, 60) + positions(0, 60, 0, 3, origin)) + mode);
    std::vector<Eigen::Vector2d> all;
    std::istringstream rows(read("out/graph.g2o"));
    for (std::string row; std::getline(rows, row);) {
      std::istringstream words(row);
      std::string tag, id;
      double x = 0, y = 0;
      if (words >> tag >> id >> x >> y && tag == "VERTEX_SE2") {
        all.emplace_back(x - origin.x(), y - origin.y());
      }
    }
    return all;
  };
  for (const std::string mode : {"", " --online", " --online --trusted odometry"}) {
    const auto near = poses(SE2(), mode), far = poses(SE2(431226, 5e6, 0), mode);
    ASSERT_EQ(near.size(), 60U);
    ASSERT_EQ(far.size(), 60U);
    for (std::size_t k = 0; k < 60; ++k) EXPECT_LT((near[k] - far[k]).norm(), 1e-6) << mode << k;
  }
}

}  // namespace
}  // namespace hybrid
