// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "libhybrid/io/write_graph.h"
#include "tests/apps/run_app.h"
#include "tests/support/pose_graph_worlds.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

class PgoStarts : public ScratchFolder {
 protected:
  nlohmann::json solve(const std::string& graph, const std::string& arguments) {
    ran = run_app("hybrid-pgo " + graph + " --method lm " + arguments + " -o " + at("out"));
    EXPECT_EQ(ran.code, 0) << ran.text;
    return nlohmann::json::parse(std::ifstream(at("out/summary.json")));
  }

  Ran ran;
};

TEST_F(PgoStarts, ScrambledPosesOfAFileDoNoHarm) {
  worlds::World world = worlds::torus(12, 20, {0.1, 0.2}, 5);
  scramble(world, 6);
  const std::string file = write("graph.g2o", to_g2o(world.graph));
  const nlohmann::json best = solve(file, "--start chordal");
  EXPECT_EQ(best["start"], "chordal");
  EXPECT_FALSE(best.contains("starts"));
  const nlohmann::json chosen = solve(file, "");
  EXPECT_EQ(chosen["start"], "chordal");
  EXPECT_NEAR(chosen["cost"], best["cost"], 1e-6 * best["cost"].get<double>());
  ASSERT_EQ(chosen["starts"].size(), 4u);
  EXPECT_EQ(chosen["starts"][0]["start"], "file");
  EXPECT_GT(chosen["starts"][0]["cost"], 2 * best["cost"].get<double>());
  EXPECT_NE(ran.text.find("the start 'chordal' won: file cost"), std::string::npos) << ran.text;
  EXPECT_EQ(solve(file, "--start auto")["cost"], chosen["cost"]);
  EXPECT_EQ(solve(file, "--start odometry")["start"], "odometry");
}

TEST_F(PgoStarts, AGoodStartIsTakenAsItIs) {
  worlds::World world = worlds::town(300, 5, 0.3, {0.05, 0.01}, 5);
  world.graph.values = world.truth;
  const std::string file = write("graph.g2o", to_g2o(world.graph));
  const nlohmann::json chosen = solve(file, "");
  EXPECT_EQ(chosen["start"], "file");
  EXPECT_FALSE(chosen.contains("starts"));
  EXPECT_EQ(ran.text.find("won"), std::string::npos) << ran.text;
  EXPECT_NEAR(solve(file, "--start tree")["cost"], chosen["cost"], 1e-4);
}

TEST_F(PgoStarts, IterationsThatRanOutAreSaidAndSettable) {
  worlds::World world = worlds::torus(12, 20, {0.1, 0.1}, 5);
  const std::string file = write("graph.g2o", to_g2o(world.graph));
  for (const char* method : {"lm", "selection"}) {
    const std::string command = "hybrid-pgo " + file + " --no-pictures --start odometry --method " +
                                method + " -o " + at("out") + " --set ";
    const Ran few = run_app(command + "solver.max_iterations=1");
    EXPECT_EQ(few.code, 2) << few.text;
    EXPECT_NE(few.text.find("iteration"), std::string::npos) << few.text;
    EXPECT_EQ(few.text.find("macro-steps"), std::string::npos) << few.text;
    const Ran many = run_app(command + "solver.max_iterations=200");
    EXPECT_EQ(many.code, 0) << many.text;
  }
}

TEST_F(PgoStarts, ACertificateTellsTheOptimumFromAnotherMinimum) {
  worlds::World world = worlds::torus(12, 20, {0.1, 0.2}, 5);
  scramble(world, 6);
  const std::string file = write("graph.g2o", to_g2o(world.graph));
  const nlohmann::json summary = solve(file, "--certify");
  const nlohmann::json best = summary["certificate"];
  EXPECT_TRUE(best["verified"]) << best;
  EXPECT_LE(best["relative_gap"], 1e-6);
  EXPECT_NE(ran.text.find("certificate: verified"), std::string::npos) << ran.text;
  EXPECT_FALSE(solve(file, "").contains("certificate"));
}

TEST_F(PgoStarts, TheStaircaseLeavesAnotherMinimum) {
  worlds::World world = worlds::torus(12, 20, {0.1, 0.2}, 5);
  scramble(world, 6);
  const std::string file = write("graph.g2o", to_g2o(world.graph));
  const double optimum = solve(file, "--start chordal")["cost"];
  const nlohmann::json summary = solve(file, "--start file --certify");
  EXPECT_NEAR(summary["cost"], optimum, 1e-6 * optimum);
  EXPECT_TRUE(summary["certificate"]["verified"]) << summary["certificate"];
  EXPECT_EQ(summary["start"], "staircase");
  ASSERT_EQ(summary["starts"].size(), 2u);
  EXPECT_EQ(summary["starts"][0]["start"], "file");
  EXPECT_GT(summary["starts"][0]["cost"], 2 * optimum);
  EXPECT_FALSE(summary["certificate"].contains("discrete_gap"));
  EXPECT_NE(ran.text.find("the start 'staircase' won: file cost"), std::string::npos) << ran.text;
}

TEST_F(PgoStarts, ACertificateOfFewClosuresBoundsAllDecisions) {
  const std::string odometry =
      "EDGE_SE2 0 1 1 0 1.5708 400 0 0 400 0 400\nEDGE_SE2 1 2 1 0 1.5708 400 0 0 400 0 400\n"
      "EDGE_SE2 2 3 1 0 1.5708 400 0 0 400 0 400\nEDGE_SE2 3 4 1 0 1.5708 400 0 0 400 0 400\n";
  const std::string file =
      write("graph.g2o", odometry + "EDGE_SE2 0 4 0.02 0 0 400 0 0 400 0 400\n" +
                             "EDGE_SE2 1 3 5 5 1 400 0 0 400 0 400\n");
  const Ran robust = run_app("hybrid-pgo " + file + " --certify -o " + at("out"));
  ASSERT_EQ(robust.code, 0) << robust.text;
  const auto summary = nlohmann::json::parse(std::ifstream(at("out/summary.json")));
  EXPECT_EQ(summary["inliers"], 1);
  EXPECT_EQ(summary["outliers"], 1);
  EXPECT_LT(summary["certificate"]["discrete_gap"], 0.1) << summary["certificate"];
  EXPECT_GE(summary["certificate"]["discrete_gap"], 0.0);
}

TEST_F(PgoStarts, ACertificateLeavesRejectedClosuresOut) {
  worlds::World world = worlds::torus(12, 20, {0.1, 0.05}, 5);
  world.graph.poses3.push_back(
      {Key('x', 3), Key('x', 130), SE3({9, 9, 9}, SO3()), Noise::isotropic(6, 0.05)});
  world.graph.values = world.truth;
  const std::string file = write("graph.g2o", to_g2o(world.graph));
  const Ran robust = run_app("hybrid-pgo " + file + " --certify -o " + at("out"));
  ASSERT_EQ(robust.code, 0) << robust.text;
  const auto summary = nlohmann::json::parse(std::ifstream(at("out/summary.json")));
  EXPECT_EQ(summary["outliers"], 1);
  EXPECT_TRUE(summary["certificate"]["verified"]) << summary["certificate"];
}

TEST_F(PgoStarts, WhatIsFixedStandsAtItsLineWithEveryStart) {
  const std::string information = " 400 0 0 400 0 10000\n";
  std::string edges, lines;
  for (int k = 0; k < 4; ++k) {
    const std::string id = std::to_string(k);
    lines += "VERTEX_SE2 " + id + ' ' + id + " 7 0\n";
    if (k < 3) edges += "EDGE_SE2 " + id + ' ' + std::to_string(k + 1) + " 1 0 0" + information;
  }
  const std::string elsewhere = "EDGE_PRIOR_SE2 3 3 0 0" + information;
  const std::string there = "EDGE_PRIOR_SE2 3 3 7 0" + information;
  const auto x_2 = [&] {
    const std::string rows = read("out/trajectory.tum");
    std::istringstream row(rows.substr(rows.find("\n2 ") + 3));
    double x = 0, y = 0;
    row >> x >> y;
    return Eigen::Vector2d(x, y);
  };
  // All lines, that of the fixed vertex alone, and one in another place than the first vertex.
  for (const std::string& text : {lines + "FIX 0\n", std::string("VERTEX_SE2 0 0 7 0\nFIX 0\n"),
                                  std::string("VERTEX_SE2 2 2 7 0\nFIX 2\n")}) {
    for (const std::string& prior : {std::string(), there, elsewhere}) {
      const std::string graph = write("g.g2o", text + edges + prior) + " --no-pictures -o ";
      for (const std::string start : {"auto", "odometry", "chordal", "tree"}) {
        for (const std::string mode :
             {"", "--method lm", "--online", "--online --trusted odometry"}) {
          const Ran run =
              run_app("hybrid-pgo " + graph + at("out") + " --start " + start + ' ' + mode);
          ASSERT_EQ(run.code, 0) << run.text;
          const bool says = run.text.find(
                                "1 of 1 poses and positions measured in the map "
                                "contradict the fixed vertices") != std::string::npos;
          EXPECT_EQ(says, prior == elsewhere) << text << prior << start << mode << run.text;
          const bool decides = mode.empty() || mode.find("odometry") != std::string::npos;
          if (prior == elsewhere && !decides) continue;
          EXPECT_LT((x_2() - Eigen::Vector2d(2, 7)).norm(), 1e-6) << text << prior << start << mode;
        }
      }
    }
  }
}

TEST_F(PgoStarts, InformationThatIsNotDefiniteIsRepairedOnlyWhereAsked) {
  const std::string good = "EDGE_SE2 0 1 1 0 0 100 0 0 100 0 400\n";
  const std::string file = write("graph.g2o", good + "EDGE_SE2 1 2 1 0 0 100 0 0 100 0 0\n");
  const Ran refused = run_app("hybrid-pgo " + file + " -o " + at("none"));
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.text.find("graph.g2o:2:1: information matrix is not positive definite; "
                              "--repair-information"),
            std::string::npos)
      << refused.text;
  const nlohmann::json summary = solve(file, "--repair-information");
  EXPECT_EQ(summary["note"], "1 information matrices were not positive definite: repaired");
  const std::string nothing = write("graph.g2o", good + "EDGE_SE2 1 2 1 0 0 -1 0 0 -1 0 -1\n");
  const Ran hopeless = run_app("hybrid-pgo " + nothing + " --repair-information -o " + at("none"));
  EXPECT_EQ(hopeless.code, 1);
  EXPECT_NE(hopeless.text.find("and none is near"), std::string::npos) << hopeless.text;
}

}  // namespace
}  // namespace hybrid
