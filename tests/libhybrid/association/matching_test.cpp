// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/matching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <set>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

MatchingProblem random_problem(int rows, int cols, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> cost(-5, 5), share(0, 1);
  MatchingProblem problem{Eigen::MatrixXd(rows, cols), Eigen::VectorXd(rows)};
  for (int i = 0; i < rows; ++i) {
    problem.unmatched[i] = cost(engine);
    for (int j = 0; j < cols; ++j) {
      problem.matched(i, j) = share(engine) < 0.3 ? kInfinity : cost(engine);
    }
  }
  return problem;
}

/// All matchings of finite cost, cheapest first.
std::vector<Matching> enumerate(const MatchingProblem& problem) {
  std::vector<Matching> all;
  Matching current;
  const int rows = static_cast<int>(problem.unmatched.size());
  const int cols = static_cast<int>(problem.matched.cols());
  std::function<void(int)> choose = [&](int i) {
    if (i == rows) {
      all.push_back(current);
      return;
    }
    for (int j = -1; j < cols; ++j) {
      const double c = j < 0 ? problem.unmatched[i] : problem.matched(i, j);
      const bool taken = j >= 0 && std::find(current.column.begin(), current.column.end(), j) !=
                                       current.column.end();
      if (taken || !std::isfinite(c)) continue;
      current.column.push_back(j);
      current.cost += c;
      choose(i + 1);
      current.cost -= c;
      current.column.pop_back();
    }
  };
  choose(0);
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  return all;
}

TEST(Matching, TheKBestEqualEnumeration) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const MatchingProblem problem =
        random_problem(static_cast<int>(seed % 5), static_cast<int>(seed / 7 % 5), seed);
    const std::vector<Matching> all = enumerate(problem);
    const std::vector<Matching> best = k_best_matchings(problem, 12, kInfinity);
    ASSERT_EQ(best.size(), std::min<std::size_t>(12, all.size())) << seed;
    std::set<std::vector<int>> distinct;
    for (std::size_t k = 0; k < best.size(); ++k) {
      EXPECT_NEAR(best[k].cost, all[k].cost, 1e-9) << seed;
      distinct.insert(best[k].column);
    }
    EXPECT_EQ(distinct.size(), best.size()) << seed;
  }
}

TEST(Matching, StopsAtTheMargin) {
  const MatchingProblem problem = random_problem(4, 4, 3);
  const std::vector<Matching> best = k_best_matchings(problem, 1000, 2.0);
  const std::vector<Matching> all = enumerate(problem);
  const auto within = std::count_if(
      all.begin(), all.end(), [&](const Matching& m) { return m.cost <= all.front().cost + 2.0; });
  EXPECT_EQ(static_cast<std::ptrdiff_t>(best.size()), within);
}

TEST(Matching, WithoutLandmarksNothingIsMatched) {
  const MatchingProblem problem{Eigen::MatrixXd(2, 0), Eigen::Vector2d(1, 2)};
  const Matching best = best_matching(problem);
  EXPECT_EQ(best.column, (std::vector<int>{-1, -1}));
  EXPECT_DOUBLE_EQ(best.cost, 3.0);
}

TEST(Matching, RefusesCostsThatAreNoNumbers) {
  MatchingProblem problem = random_problem(2, 2, 1);
  problem.matched(0, 1) = std::nan("");
  EXPECT_THROW(best_matching(problem), Error);
  problem = random_problem(2, 2, 1);
  problem.unmatched[0] = kInfinity;
  EXPECT_THROW(best_matching(problem), Error);
  problem.unmatched = Eigen::Vector3d::Zero();
  EXPECT_THROW(best_matching(problem), Error);
}

}  // namespace
}  // namespace hybrid
