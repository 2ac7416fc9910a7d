// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <ostream>
#include <string>

#include "libhybrid/io/read_graph.h"
#include "libhybrid/io/write_graph.h"
#include "tests/support/data_path.h"

namespace hybrid {
namespace {

struct DataFile {
  std::string name;
  std::size_t vertices, odometry, loops, poses;
};

void PrintTo(const DataFile& file, std::ostream* out) {
  *out << file.name;
}

class PublicGraph : public ::testing::TestWithParam<DataFile> {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(path())) GTEST_SKIP() << path() << " is absent";
    graph_ = read_graph(path());
  }
  std::string path() const { return testing::data_path(GetParam().name); }

  PoseGraph graph_;
};

template <class T>
std::size_t count_odometry(const std::vector<GraphEdge<T>>& edges) {
  std::size_t count = 0;
  for (const auto& edge : edges) count += edge.to.index() == edge.from.index() + 1;
  return count;
}

TEST_P(PublicGraph, HasItsPublishedCounts) {
  EXPECT_EQ(graph_.values.size(), GetParam().vertices);
  EXPECT_EQ(graph_.edge_count(), GetParam().odometry + GetParam().loops);
  EXPECT_EQ(count_odometry(graph_.poses2) + count_odometry(graph_.poses3), GetParam().odometry);
}

TEST_P(PublicGraph, StartsFromOdometryAndHasFactors) {
  const Values values = initialize_from_odometry(graph_);
  EXPECT_EQ(values.size(), GetParam().poses);
  const auto factors = to_factors(graph_, values);
  EXPECT_EQ(factors.size(), graph_.edge_count() + 1);
  std::size_t exact = 0;
  for (const auto& factor : factors) exact += factor->cost(values) < 1e-9;
  EXPECT_GE(exact, GetParam().odometry) << "chained odometry has no error";
}

TEST_P(PublicGraph, SurvivesARoundTrip) {
  const PoseGraph again = parse_graph(to_g2o(graph_), "written");
  EXPECT_EQ(again.values.size(), graph_.values.size());
  const Values values = initialize_from_odometry(graph_);
  const auto before = to_factors(graph_, values);
  const auto after = to_factors(again, values);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double cost = before[i]->cost(values);
    EXPECT_NEAR(after[i]->cost(values), cost, 1e-9 * (1.0 + cost));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Files, PublicGraph,
    ::testing::Values(DataFile{"pose_graphs/CSAIL.g2o", 0, 1044, 128, 1045},
                      DataFile{"pose_graphs/intel.g2o", 1728, 1727, 785, 1728},
                      DataFile{"pose_graphs/manhattan.g2o", 0, 3499, 1954, 3500},
                      DataFile{"pose_graphs/city10000.g2o", 10000, 9999, 10688, 10000},
                      DataFile{"pose_graphs/sphere2500.g2o", 2500, 2499, 2450, 2500},
                      DataFile{"pose_graphs/parking-garage.g2o", 1661, 1660, 4615, 1661},
                      DataFile{"pose_graphs_gt/manhattanOlson3500.g2o", 3500, 3499, 2099, 3500}),
    [](const auto& instance) {
      std::string name = std::filesystem::path(instance.param.name).stem().string();
      name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
      return name;
    });

}  // namespace
}  // namespace hybrid
