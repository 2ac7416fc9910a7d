// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "libhybrid/core/sort_unique.h"
#include "libhybrid/linear/block_cholesky.h"

namespace hybrid {
namespace {

struct RandomSystem {
  BlockOrdering ordering;
  BlockMatrix matrix;
  Eigen::MatrixXd dense;
};

/// A positive definite block matrix: `n` blocks of dimensions 1 to `largest`, a chain and random
/// edges.
RandomSystem random_system(int n, int edges, int largest, unsigned seed,
                           BlockMatrix::Triangle triangle = BlockMatrix::Triangle::kLower) {
  std::mt19937 rng(seed);
  BlockPattern pattern;
  for (int i = 0; i < n; ++i) {
    pattern.dims.push_back(std::uniform_int_distribution<int>(1, largest)(rng));
    if (i > 0) pattern.edges.emplace_back(i - 1, i);
  }
  for (int e = 0; e < edges; ++e) {
    const int a = std::uniform_int_distribution<int>(0, n - 1)(rng);
    const int b = std::uniform_int_distribution<int>(0, n - 1)(rng);
    if (a != b) pattern.edges.emplace_back(std::min(a, b), std::max(a, b));
  }
  sort_unique(pattern.edges);
  RandomSystem system;
  system.ordering = order_blocks(pattern);
  system.matrix = BlockMatrix(pattern, system.ordering.order, triangle);
  BlockMatrix& matrix = system.matrix;
  std::normal_distribution<double> normal;
  system.dense = Eigen::MatrixXd::Zero(matrix.scalars(), matrix.scalars());
  for (int b = 0; b < matrix.block_count(); ++b) {
    const BlockMatrix::Block& block = matrix.block(b);
    for (int c = 0; c < matrix.dim(block.col); ++c) {
      for (int r = 0; r < matrix.dim(block.row); ++r) {
        const int row = matrix.start(block.row) + r;
        const int col = matrix.start(block.col) + c;
        const double x = block.row == block.col && row < col ? system.dense(row, col) : normal(rng);
        matrix.values()[block.offset + c * matrix.stride(block.col) + r] = x;
        system.dense(row, col) = system.dense(col, row) = x;
      }
    }
  }
  for (int i = 0; i < matrix.scalars(); ++i) {
    const double x = system.dense.row(i).cwiseAbs().sum() + 1.0;
    system.dense(i, i) = x;
    matrix.values()[matrix.diagonal_offset(i)] = x;
  }
  return system;
}

double solve_error(const RandomSystem& system, Eigen::VectorXd x) {
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(system.matrix.scalars());
  return (system.dense * x - b).cwiseAbs().maxCoeff();
}

TEST(BlockCholesky, SolvesRandomSystems) {
  WorkerPool pool(2);
  for (unsigned seed = 0; seed < 60; ++seed) {
    const RandomSystem system = random_system(1 + seed * 2, seed * 3, 1 + seed % 7, seed);
    BlockCholesky cholesky(system.matrix, system.ordering);
    const std::vector<double> none(system.matrix.scalars(), 0.0);
    ASSERT_EQ(cholesky.factorize(system.matrix, none.data(), pool), -1);
    Eigen::VectorXd x = Eigen::VectorXd::Ones(system.matrix.scalars());
    cholesky.solve(x.data());
    EXPECT_LT(solve_error(system, x), 1e-11) << "seed " << seed;
    const Eigen::MatrixXd l = Eigen::LLT<Eigen::MatrixXd>(system.dense).matrixL();
    for (int i = 0; i < system.matrix.scalars(); ++i) {
      EXPECT_NEAR(cholesky.diagonal(i), l(i, i), 1e-10 * l(i, i));
    }
  }
}

TEST(BlockCholesky, AddsTheExtraDiagonal) {
  RandomSystem system = random_system(30, 40, 3, 1);
  const Eigen::VectorXd extra = Eigen::VectorXd::LinSpaced(system.matrix.scalars(), 1.0, 9.0);
  WorkerPool pool(1);
  BlockCholesky cholesky(system.matrix, system.ordering);
  ASSERT_EQ(cholesky.factorize(system.matrix, extra.data(), pool), -1);
  Eigen::VectorXd x = Eigen::VectorXd::Ones(system.matrix.scalars());
  cholesky.solve(x.data());
  system.dense.diagonal() += extra;
  EXPECT_LT(solve_error(system, x), 1e-12);
}

TEST(BlockCholesky, IsTheSameForAnyNumberOfThreads) {
  const RandomSystem system = random_system(700, 900, 6, 2);
  const std::vector<double> none(system.matrix.scalars(), 0.0);
  BlockCholesky one(system.matrix, system.ordering);
  BlockCholesky two(system.matrix, system.ordering);
  ASSERT_GT(one.tasks().size(), 1u);
  WorkerPool single(1), pair(2);
  one.factorize(system.matrix, none.data(), single);
  two.factorize(system.matrix, none.data(), pair);
  for (int s = 0; s < one.supernode_count(); ++s) {
    const BlockCholesky::Supernode& node = one.supernode(s);
    for (int c = 0; c < node.columns; ++c) {
      for (int r = c; r < node.height; ++r) {
        ASSERT_EQ(one.panel(node)[c * node.stride + r], two.panel(node)[c * node.stride + r]);
      }
    }
  }
}

TEST(BlockCholesky, AgreesWithCholmodWhereAPivotFails) {
  WorkerPool pool(1);
  for (unsigned seed = 0; seed < 20; ++seed) {
    RandomSystem system = random_system(40, 30, 3, seed);
    const int bad = static_cast<int>(seed * 37 % system.matrix.scalars());
    system.matrix.values()[system.matrix.diagonal_offset(bad)] = -1.0;
    const std::vector<double> none(system.matrix.scalars(), 0.0);
    BlockCholesky ours(system.matrix, system.ordering);
    Cholesky cholmod(system.matrix);
    EXPECT_EQ(ours.factorize(system.matrix, none.data(), pool), bad);
    EXPECT_EQ(cholmod.factorize(system.matrix), bad);
  }
}

TEST(BlockCholesky, FindsANaN) {
  RandomSystem system = random_system(10, 5, 3, 3);
  system.matrix.values()[system.matrix.diagonal_offset(4)] =
      std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> none(system.matrix.scalars(), 0.0);
  WorkerPool pool(1);
  BlockCholesky ours(system.matrix, system.ordering);
  EXPECT_EQ(ours.factorize(system.matrix, none.data(), pool), 4);
}

TEST(Cholesky, SolvesByCholmodFromEitherTriangle) {
  for (const auto triangle : {BlockMatrix::Triangle::kLower, BlockMatrix::Triangle::kUpper}) {
    const RandomSystem system = random_system(50, 60, 4, 4, triangle);
    Cholesky cholesky(system.matrix);
    ASSERT_EQ(cholesky.factorize(system.matrix), -1);
    Eigen::VectorXd x = Eigen::VectorXd::Ones(system.matrix.scalars());
    cholesky.solve(x.data());
    EXPECT_LT(solve_error(system, x), 1e-11);
  }
}

TEST(BlockMatrix, MultipliesAsTheDenseMatrix) {
  for (const auto triangle : {BlockMatrix::Triangle::kLower, BlockMatrix::Triangle::kUpper}) {
    const RandomSystem system = random_system(20, 30, 4, 5, triangle);
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(system.matrix.scalars(), -1.0, 1.0);
    Eigen::VectorXd y(x.size());
    system.matrix.multiply(x.data(), y.data());
    EXPECT_LT((y - system.dense * x).norm(), 1e-11);
  }
}

/// A chain of links of unit information that one weak prior holds: eliminated towards the prior,
/// no pivot is less than that of a link, however long the chain is.
TEST(OrderBlocks, PivotsAlongAChainTowardsItsAnchorAreThoseOfTheLinks) {
  constexpr int kLength = 5000;
  constexpr double kPrior = 1e-12;
  for (const int anchor : {0, 1234, kLength - 1}) {
    BlockPattern pattern;
    pattern.dims.assign(kLength, 1);
    for (int i = 1; i < kLength; ++i) pattern.edges.emplace_back(i - 1, i);
    pattern.anchor = anchor;
    EXPECT_EQ(order_blocks(pattern, Trees::kLow).order.back(), anchor);
    const BlockOrdering ordering = order_blocks(pattern, Trees::kAnyHeight);
    ASSERT_EQ(ordering.order.back(), anchor);
    BlockMatrix matrix(pattern, ordering.order, BlockMatrix::Triangle::kLower);
    for (int b = 0; b < matrix.block_count(); ++b) {
      const BlockMatrix::Block& block = matrix.block(b);
      const int i = ordering.order[block.row];
      const double links = i == 0 || i == kLength - 1 ? 1 : 2;
      const double diagonal = links + (i == anchor ? kPrior : 0.0);
      matrix.values()[block.offset] = block.row == block.col ? diagonal : -1.0;
    }
    WorkerPool pool(1);
    BlockCholesky factor(matrix, ordering);
    ASSERT_EQ(factor.factorize(matrix, std::vector<double>(kLength, 0.0).data(), pool), -1);
    for (int k = 0; k + 1 < kLength; ++k) ASSERT_GE(factor.diagonal(k), 1.0) << k;
    EXPECT_NEAR(factor.diagonal(kLength - 1), std::sqrt(kPrior), 1e-3 * std::sqrt(kPrior));
  }
}

}  // namespace
}  // namespace hybrid
