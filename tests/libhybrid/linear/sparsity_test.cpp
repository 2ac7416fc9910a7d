// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/sparsity.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <memory>
#include <numeric>
#include <random>

#include "libhybrid/core/error.h"
#include "libhybrid/core/sort_unique.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"

namespace hybrid {
namespace {

/// A random symmetric pattern, and a positive definite matrix of random values with one scalar per
/// block.
struct RandomMatrix {
  BlockPattern pattern;
  Eigen::MatrixXd matrix;
};

RandomMatrix random_matrix(unsigned seed, int size) {
  std::mt19937 random(seed);
  RandomMatrix result;
  result.pattern.dims.assign(size, 1);
  result.matrix = Eigen::MatrixXd::Identity(size, size) * 8.0;
  std::uniform_real_distribution<double> value(0.2, 1.0);
  for (int k = 0; k < 3 * size / 2; ++k) {
    const int i = static_cast<int>(random() % size);
    const int j = static_cast<int>(random() % size);
    if (i == j) continue;
    result.pattern.edges.emplace_back(std::min(i, j), std::max(i, j));
    result.matrix(i, j) = result.matrix(j, i) = (random() % 2 == 0 ? 1 : -1) * value(random);
  }
  sort_unique(result.pattern.edges);
  return result;
}

Blocks nonzeros_of_lower(const Eigen::MatrixXd& matrix) {
  Blocks blocks;
  for (int i = 0; i < matrix.rows(); ++i) {
    for (int j = 0; j <= i; ++j) {
      if (std::abs(matrix(i, j)) > 1e-14) blocks.emplace_back(i, j);
    }
  }
  return blocks;
}

/// Random values do not cancel, so that structural and numeric nonzeros are the same.
void expect_same(const FilledPattern& pattern, const Eigen::MatrixXd& numeric) {
  Blocks all = pattern.original;
  all.insert(all.end(), pattern.fill.begin(), pattern.fill.end());
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, nonzeros_of_lower(numeric));
}

TEST(Sparsity, FactorHasTheNonzerosOfANumericCholesky) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int n = 12;
    const RandomMatrix random = random_matrix(seed, n);
    std::vector<int> order(n);
    std::iota(order.begin(), order.end(), 0);
    std::mt19937 generator(seed);
    std::shuffle(order.begin(), order.end(), generator);
    const Eigen::MatrixXd permuted = random.matrix(order, order);
    const FilledPattern factor = cholesky_pattern(random.pattern, order);
    EXPECT_EQ(factor.original, nonzeros_of_lower(permuted));
    const Eigen::MatrixXd L = permuted.llt().matrixL();
    expect_same(factor, L);
  }
}

TEST(Sparsity, MarginalHasTheNonzerosOfANumericSchurComplement) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int n = 12;
    const RandomMatrix random = random_matrix(seed, n);
    std::mt19937 generator(seed);
    std::vector<char> removed(n, 0);
    std::vector<int> gone, kept;
    for (int i = 0; i < n; ++i) {
      removed[i] = static_cast<char>(i == 0 || (i != 1 && generator() % 2 == 0));
      (removed[i] ? gone : kept).push_back(i);
    }
    const Eigen::MatrixXd& m = random.matrix;
    const Eigen::MatrixXd before = m(kept, kept);
    const Eigen::MatrixXd inverse = Eigen::MatrixXd(m(gone, gone)).inverse();
    const Eigen::MatrixXd schur = before - m(kept, gone) * inverse * m(gone, kept);
    const FilledPattern marginal = marginalized_pattern(random.pattern, removed);
    EXPECT_EQ(marginal.original, nonzeros_of_lower(before));
    expect_same(marginal, schur);
  }
}

TEST(Sparsity, JacobianFollowsTheAssignment) {
  const Key x0{'x', 0}, x1{'x', 1}, x2{'x', 2}, d{'d', 0};
  const Noise noise = Noise::isotropic(3, 0.1);
  HybridGraph graph;
  graph.emplace<Prior<SE2>>(x0, SE2(), noise);
  graph.emplace<BetweenSE2>(x1, x0, SE2(), noise);
  graph.emplace<BetweenSE2>(x1, x2, SE2(), noise);
  const auto closure = std::make_shared<BetweenSE2>(x0, x2, SE2(), noise);
  const auto wide = std::make_shared<BetweenSE2>(x0, x2, SE2(), Noise::isotropic(3, 300.0));
  graph.add(make_outlier_mixture({d, 2}, closure, wide, 0.5, 0.5));
  std::vector<std::size_t> closures;
  for (int value : {0, 1}) {
    Assignment assignment;
    assignment.set(d, value);
    const JacobianPattern jacobian = jacobian_pattern(graph, assignment);
    EXPECT_EQ(jacobian.variables, (std::vector<Key>{x0, x1, x2}));
    EXPECT_EQ(jacobian.dims, (std::vector<int>{3, 3, 3}));
    EXPECT_EQ(jacobian.index(x2), 2);
    EXPECT_THROW(jacobian.index({'x', 9}), Error);
    closures.push_back(jacobian.factors.size() - 3);
    EXPECT_EQ(jacobian_blocks(jacobian).size(), 5 + 2 * closures.back());
    EXPECT_EQ(information_pattern(jacobian).edges.size(), 2 + closures.back());
  }
  std::sort(closures.begin(), closures.end());
  EXPECT_EQ(closures, (std::vector<std::size_t>{0, 1}));  // the outlier component couples nothing
}

TEST(Sparsity, RejectsOrdersThatAreNone) {
  BlockPattern pattern;
  pattern.dims = {3, 3};
  EXPECT_THROW(cholesky_pattern(pattern, {0}), Error);
  EXPECT_THROW(cholesky_pattern(pattern, {0, 0}), Error);
  EXPECT_THROW(cholesky_pattern(pattern, {0, 2}), Error);
  EXPECT_EQ(cholesky_pattern(pattern, {1, 0}).original, (Blocks{{0, 0}, {1, 1}}));
}

}  // namespace
}  // namespace hybrid
