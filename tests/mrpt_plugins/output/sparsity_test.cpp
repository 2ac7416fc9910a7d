// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "mrpt_plugins/output/sparsity.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "mrpt_plugins/drawing/matrix_image.h"
#include "mrpt_plugins/output/graph_image.h"

namespace hybrid {
namespace {

int pixels_of(const Image& image, Color color) {
  int count = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    count += image.rgb[i] == color.red && image.rgb[i + 1] == color.green &&
             image.rgb[i + 2] == color.blue;
  }
  return count;
}

TEST(MatrixImage, EveryEntryIsSeenHoweverLargeTheMatrix) {
  const Color color{1, 200, 3};
  int of_one = 0;
  for (const int size : {10, 1000, 100000}) {
    MatrixPanel panel{"", size, size, "row", "column", {{"none", {9, 9, 9}, {}}}};
    const int before = pixels_of(matrix_image("", "", {panel}), color);
    panel.layers.push_back({"", color, {{size / 2, size / 3}}});
    of_one = pixels_of(matrix_image("", "", {panel}), color) - before;
    EXPECT_GT(of_one, 50) << size;  // the sample in the legend and the entry
  }
  MatrixPanel panel{"",    100000,   100000,
                    "row", "column", {{"", color, {{20000, 30000}, {90000, 80000}}}}};
  EXPECT_GT(pixels_of(matrix_image("", "", {panel}), color), of_one);
}

TEST(MatrixImage, RejectsWhatCannotBeDrawn) {
  EXPECT_THROW(matrix_image("", "", {{"", 3, 0, "", "", {}}}), std::invalid_argument);
  EXPECT_THROW(matrix_image("", "", {{"", 3, 3, "", "", {{"", {}, {{3, 0}}}}}}),
               std::invalid_argument);
  EXPECT_THROW(matrix_image("", "", {{"", 3, 3, "", "", {{"", {}, {{0, -1}}}}}}),
               std::invalid_argument);
}

TEST(GraphImage, ShowsClosuresApartFromOdometry) {
  const Color closure{213, 94, 0};
  GraphDrawing graph;
  graph.poses = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  graph.odometry = {{graph.poses[0], graph.poses[1]}, {graph.poses[1], graph.poses[2]}};
  EXPECT_EQ(pixels_of(graph_image(graph), closure), 0);
  EXPECT_GT(pixels_of(graph_image(graph), palette::kEstimate), 500);
  graph.closures = {{graph.poses[2], graph.poses[0]}};
  EXPECT_GT(pixels_of(graph_image(graph), closure), 20);
}

class WriteSparsity : public ::testing::Test {
 protected:
  WriteSparsity() {
    graph.emplace<Prior<SE2>>(Key{'x', 0}, SE2(), noise);
    for (std::uint64_t i = 1; i < 6; ++i) {
      graph.emplace<BetweenSE2>(Key{'x', i - 1}, Key{'x', i}, SE2(1, 0, 0), noise);
    }
  }
  ~WriteSparsity() override { std::filesystem::remove_all(folder); }

  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("hybrid_sparsity_" + std::to_string(getpid()));
  const Noise noise = Noise::isotropic(3, 0.1);
  HybridGraph graph;
};

TEST_F(WriteSparsity, WritesFourPictures) {
  OutputDirectory out(folder);
  EXPECT_TRUE(write_sparsity(out, graph, {}, {}, "chain").empty());
  EXPECT_THROW(write_sparsity(out, HybridGraph(), {}, {}, "nothing"), Error);
  EXPECT_THROW(write_sparsity(out, graph, {}, {Key{'x', 2}}, "half an order"), Error);
  out.publish({{"status", "ok"}});
  for (const char* name : {"jacobian", "information", "factor", "marginalized"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / ("sparsity_" + std::string(name) + ".png")));
  }
}

TEST_F(WriteSparsity, TakesTheOrderOfASmoother) {
  IncrementalSmoother smoother;
  Delta delta;
  for (std::uint64_t i = 0; i < 6; ++i) delta.values.insert(Key{'x', i}, SE2(double(i), 0, 0));
  graph.continuous().for_each(
      [&](Handle, const ContinuousFactorPtr& factor) { delta.continuous.push_back(factor); });
  ASSERT_EQ(smoother.update(delta).status, UpdateReport::Status::kOk);
  const std::vector<Key> order = smoother.elimination_order();
  EXPECT_EQ(order.size(), 6u);
  EXPECT_TRUE(write_sparsity(OutputDirectory(folder), smoother.graph(), {}, order, "s").empty());
}

}  // namespace
}  // namespace hybrid
