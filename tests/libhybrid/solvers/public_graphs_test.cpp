// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "libhybrid/io/read_graph.h"
#include "libhybrid/solvers/dogleg.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/data_path.h"

namespace hybrid {
namespace {

struct PublicGraph {
  const char* name;
  double optimum;  ///< half the weighted squared error, by an independent solver
};

std::ostream& operator<<(std::ostream& out, const PublicGraph& graph) {
  return out << graph.name;
}

class PublicGraphs : public ::testing::TestWithParam<PublicGraph> {
 protected:
  void SetUp() override {
    const std::string path =
        testing::data_path(std::string("pose_graphs/") + GetParam().name + ".g2o");
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    const PoseGraph file = read_graph(path);
    initial_.values = file.values.empty() ? initialize_from_odometry(file) : file.values;
    for (auto& factor : to_factors(file, initial_.values)) graph_.add(std::move(factor));
  }

  void expect_optimum(const SolverResult& result) const {
    EXPECT_EQ(result.report.status, SolverStatus::kConverged) << result.report.message;
    EXPECT_NEAR(result.report.final_cost(), GetParam().optimum, 2e-4 * GetParam().optimum);
    EXPECT_TRUE(std::is_sorted(result.report.costs.rbegin(), result.report.costs.rend()));
  }

  HybridGraph graph_;
  Estimate initial_;
};

TEST_P(PublicGraphs, LevenbergMarquardtReachesTheOptimum) {
  expect_optimum(levenberg_marquardt(graph_, initial_));
}

TEST_P(PublicGraphs, DoglegReachesTheOptimum) {
  expect_optimum(dogleg(graph_, initial_));
}

INSTANTIATE_TEST_SUITE_P(
    , PublicGraphs,
    ::testing::Values(PublicGraph{"CSAIL", 20.2776}, PublicGraph{"intel", 22.5023},
                      PublicGraph{"manhattan", 1774.518}, PublicGraph{"parking-garage", 0.634192},
                      PublicGraph{"sphere2500", 675.7010}, PublicGraph{"city10000", 255.9926}),
    [](const auto& info) {
      std::string name = info.param.name;
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

TEST(PublicGraph, City10000ConvergesFromChainedOdometry) {
  const std::string path = testing::data_path("pose_graphs/city10000.g2o");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  PoseGraph file = read_graph(path);
  file.values = {};
  Estimate initial;
  initial.values = initialize_from_odometry(file);
  HybridGraph graph;
  for (auto& factor : to_factors(file, initial.values)) graph.add(std::move(factor));
  const SolverResult result = levenberg_marquardt(graph, initial);
  EXPECT_EQ(result.report.status, SolverStatus::kConverged) << result.report.message;
  EXPECT_NEAR(result.report.final_cost(), 255.99, 0.05);
}

}  // namespace
}  // namespace hybrid
