// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/correlative_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "libhybrid/scans/scan_points.h"
#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

std::vector<Eigen::Vector2d> positions_seen(const testing::FloorPlan& plan, const SE2& pose) {
  std::mt19937 random(1);
  std::vector<Eigen::Vector2d> positions;
  for (const SurfacePoint& point : scan_points(plan.scan(pose, 361, 0.01, random))) {
    positions.push_back(point.position);
  }
  return positions;
}

double score_at(const std::vector<Eigen::Vector2d>& points, const LikelihoodField& field,
                const SE2& pose) {
  double sum = 0.0;
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2i cell = field.cell(pose * p);
    sum += field.at(0, cell.x(), cell.y());
  }
  return sum / (255.0 * double(points.size()));
}

TEST(SearchPoses, FindsAPoseFarFromTheCentreOfTheWindow) {
  const testing::FloorPlan plan = testing::furnished_room();
  const auto map = positions_seen(plan, SE2());
  const LikelihoodField field(map, 0.1, 0.12);
  for (const SE2& truth : {SE2(0.9, -0.7, 0.4), SE2(-0.3, 0.8, -0.5), SE2(0.0, 0.0, 0.1)}) {
    const auto seen = positions_seen(plan, truth);
    SearchWindow window;
    window.reach = {1.0, 1.0};
    window.turn = 0.6;
    const auto modes = search_poses(seen, field, window);
    ASSERT_FALSE(modes.empty());
    EXPECT_LT((modes[0].pose.translation() - truth.translation()).norm(), 0.15);
    EXPECT_NEAR(modes[0].pose.angle(), truth.angle(), 0.05);
    EXPECT_NEAR(modes[0].score, score_at(seen, field, modes[0].pose), 1e-9);
  }
}

TEST(SearchPoses, NoPoseOfTheWindowIsBetter) {
  const testing::FloorPlan plan = testing::furnished_room();
  const LikelihoodField field(positions_seen(plan, SE2()), 0.1, 0.12);
  const auto seen = positions_seen(plan, SE2(0.3, 0.2, 0.1));
  SearchWindow window;
  window.reach = {0.5, 0.5};
  window.turn = 0.0;
  const auto modes = search_poses(seen, field, window);
  ASSERT_FALSE(modes.empty());
  for (int x = -5; x <= 5; ++x) {
    for (int y = -5; y <= 5; ++y) {
      EXPECT_LE(score_at(seen, field, SE2(0.1 * x, 0.1 * y, 0.0)), modes[0].score + 1e-9);
    }
  }
}

TEST(SearchPoses, ReportsBothModesOfASymmetricPlace) {
  // Equal pillars 2 m apart in a row: a shift by one of them leaves most as it is.
  std::vector<Eigen::Vector2d> pillars;
  for (int i = 0; i < 8; ++i) {
    for (const double d : {0.0, 0.1, 0.2}) pillars.emplace_back(2.0 * i + d, 3.0);
  }
  SearchWindow window;
  window.reach = {2.4, 0.4};
  SearchOptions options;
  options.ratio = 0.8;
  const auto modes = search_poses(pillars, LikelihoodField(pillars, 0.1, 0.12), window, options);
  ASSERT_EQ(modes.size(), 3u);
  EXPECT_LT(modes[0].pose.translation().norm(), 0.15);
  EXPECT_NEAR(std::abs(modes[1].pose.x()), 2.0, 0.15);
  EXPECT_NEAR(modes[1].pose.x(), -modes[2].pose.x(), 0.3);
}

TEST(SearchPoses, OfManyEquallyGoodPosesTheFirstAreKept) {
  // A row of equal pillars twice as long as what is seen of it: seven places look alike.
  std::vector<Eigen::Vector2d> row, seen;
  for (int i = -7; i < 8; ++i) {
    for (const double d : {0.0, 0.1, 0.2}) row.emplace_back(2.0 * i + d, 3.0);
  }
  for (const Eigen::Vector2d& p : row) {
    if (std::abs(p.x()) < 5.0) seen.push_back(p);
  }
  SearchWindow window;
  window.reach = {6.4, 0.4};
  SearchOptions options;
  const LikelihoodField field(row, 0.1, 0.12);
  EXPECT_EQ(search_poses(seen, field, window, options).size(), 4U);
  options.max_modes = 20;
  EXPECT_EQ(search_poses(seen, field, window, options).size(), 7U);
}

TEST(SearchPoses, EndsWithinItsBudget) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-8.0, 8.0);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 2000; ++i) points.emplace_back(place(random), place(random));
  SearchWindow window;
  window.reach = {8.0, 8.0};
  window.turn = 0.8;
  SearchOptions options;
  options.budget = 1000;
  EXPECT_LE(search_poses(points, LikelihoodField(points, 0.1, 0.12), window, options).size(), 4u);
  EXPECT_TRUE(search_poses({}, LikelihoodField(points, 0.1, 0.12), window).empty());
  EXPECT_TRUE(search_poses(points, LikelihoodField(), window).empty());
}

}  // namespace
}  // namespace hybrid
