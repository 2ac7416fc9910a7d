// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Random systems with blocks of which nothing is said, that stand alone, or that are tied to all.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

#include "libhybrid/core/rank_update.h"
#include "libhybrid/linear/bayes_tree.h"
#include "libhybrid/linear/extended_cholesky.h"
#include "libhybrid/linear/normal_equations.h"
#include "libhybrid/linear/path_inverse.h"
#include "libhybrid/linear/selected_inverse.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;

/// A system, and which of its blocks nothing is said of.
struct Case {
  ResidualLayout layout;
  std::vector<double> r, J;
  std::vector<bool> silent;
  bool singular = false;

  explicit Case(std::uint64_t seed) {
    Random random(seed);
    const int blocks = random.below(30);
    for (int b = 0; b < blocks; ++b) {
      layout.dims.push_back(1 + random.below(6));
      silent.push_back(random.below(seed % 2 == 0 ? 8 : 1000000) == 0);
      singular = singular || silent.back();
    }
    const int ties = random.below(blocks + 1);  // of each block with others
    for (int b = 0; b < blocks; ++b) {
      if (silent[b] && random.below(2) == 0) continue;  // of some, no residual at all
      add(random, {b}, layout.dims[b]);
      for (int k = 0; k < ties; ++k) {
        const int other = random.below(blocks);
        if (other != b) add(random, {b, other}, 1 + random.below(3));
      }
    }
    r.resize(layout.residual_size);
    for (double& x : r) x = random.normal();
  }

 private:
  void add(Random& random, const std::vector<int>& touched, int rows) {
    layout.add(rows, touched.data(), static_cast<int>(touched.size()), random.below(5) != 0);
    for (int b : touched) {
      for (int i = 0; i < rows * layout.dims[b]; ++i) {
        J.push_back(silent[b] ? 0.0 : random.normal());
      }
    }
  }
};

int dimension(const Case& c, bool silent) {
  int sum = 0;
  for (std::size_t b = 0; b < c.layout.dims.size(); ++b) {
    if (c.silent[b] == silent) sum += c.layout.dims[b];
  }
  return sum;
}

TEST(EmptyBlocks, NothingToAddIsNothing) {
  Eigen::MatrixXd square = Eigen::MatrixXd::Identity(60, 60);
  rank_update(square, Eigen::MatrixXd(60, 0), -1.0);
  EXPECT_TRUE(square.isIdentity(0.0));
  rank_update(square, Eigen::MatrixXd::Ones(60, 1), 1.0);
  EXPECT_EQ(square(59, 0), 1.0);
}

TEST(EmptyBlocks, TheExtendedFactorNamesThem) {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    const Case c(seed);
    const ExtendedCholesky factor(c.layout, c.J.data());
    EXPECT_EQ(factor.nullity(), dimension(c, true)) << seed;
    EXPECT_EQ(std::isfinite(factor.log_determinant()), !c.singular) << seed;
    for (int b = 0; b < static_cast<int>(c.layout.dims.size()); ++b) {
      EXPECT_EQ(factor.free_directions(b).cols(), c.silent[b] ? c.layout.dims[b] : 0) << seed;
      EXPECT_TRUE(factor.covariance({b}).allFinite()) << seed;
    }
  }
}

TEST(EmptyBlocks, FactorsInDoubleRefuseThem) {
  WorkerPool pool(1);
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    const Case c(seed);
    for (const Elimination elimination : {Elimination::kPlain, Elimination::kSchur}) {
      NormalEquations system(c.layout, elimination);
      system.assemble(c.r.data(), c.J.data(), pool);
      for (const double damping : {0.0, 1e-3}) {
        const int failed = system.factorize(damping, pool);
        EXPECT_EQ(failed >= 0, c.singular && damping == 0.0) << seed << ", damping " << damping;
        if (failed >= 0) continue;
        std::vector<double> x = system.gradient();
        system.solve(x.data());
        for (double e : x) EXPECT_TRUE(std::isfinite(e)) << seed;
      }
      if (c.singular || system.by_schur()) continue;
      ASSERT_EQ(system.factorize(0.0, pool), -1);
      const SelectedInverse inverse(system.cholesky(), pool);
    }
  }
}

TEST(EmptyBlocks, TheBayesTreeNamesOne) {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    const Case c(seed);
    BayesTree tree;
    for (int b = 0; b < static_cast<int>(c.layout.dims.size()); ++b) {
      tree.add_variable(b, c.layout.dims[b]);
    }
    for (const auto& residual : c.layout.residuals) {
      const std::vector<int> blocks(c.layout.blocks.begin() + residual.first,
                                    c.layout.blocks.begin() + residual.first + residual.count);
      int columns = 1;
      for (int b : blocks) columns += c.layout.dims[b];
      Eigen::MatrixXd A(residual.rows, columns);
      std::copy_n(c.J.data() + residual.jacobian, residual.rows * (columns - 1), A.data());
      std::copy_n(c.r.data() + residual.residual, residual.rows, A.rightCols(1).data());
      double* packed = tree.hessian(tree.add_factor(blocks));
      const Eigen::MatrixXd H = A.transpose() * A;
      for (int j = 0; j < columns; ++j) {
        for (int i = j; i < columns; ++i) *packed++ = H(i, j);
      }
    }
    const EliminationReport report = tree.eliminate({});
    EXPECT_EQ(report.singular >= 0, c.singular) << seed;
    if (report.singular >= 0) {
      EXPECT_TRUE(c.silent[report.singular]) << seed;
      continue;
    }
    tree.solve(0.0);
    EXPECT_TRUE(std::isfinite(tree.log_determinant())) << seed;
  }
}

}  // namespace
}  // namespace hybrid
