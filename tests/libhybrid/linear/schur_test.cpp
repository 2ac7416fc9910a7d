// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/schur.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "libhybrid/linear/normal_equations.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;

/// Poses in a chain and landmarks, each measured by some of them, with random Jacobians.
struct System {
  ResidualLayout layout;
  std::vector<double> r, J;
};

System random_system(int poses, int landmarks, int landmark_dim, std::uint64_t seed) {
  Random random(seed);
  System s;
  s.layout.dims.assign(landmarks, landmark_dim);  // landmarks first, so that the order must change
  s.layout.dims.insert(s.layout.dims.end(), poses, 2 * landmark_dim);
  for (int p = 0; p < poses; ++p) {
    const int own[] = {landmarks + p};
    s.layout.add(2 * landmark_dim, own, 1, true);
    const int step[] = {landmarks + p, landmarks + (p + 1) % poses};
    s.layout.add(2 * landmark_dim, step, 2, p % 3 != 0);
  }
  for (int l = 0; l < landmarks; ++l) {
    const int first = random.below(poses);
    for (int k = 0; k <= random.below(5); ++k) {
      const int pair[] = {landmarks + (first + k * 3) % poses, l};
      s.layout.add(landmark_dim + 1, pair, 2, true);
    }
  }
  s.r.resize(s.layout.residual_size);
  s.J.resize(s.layout.jacobian_size);
  for (double& x : s.r) x = random.normal();
  for (double& x : s.J) x = random.normal();
  return s;
}

/// The step by block and the smallest pivot ratio.
std::vector<double> solve(const System& s, Elimination elimination, double damping, int threads,
                          bool expect_schur) {
  WorkerPool pool(threads);
  NormalEquations system(s.layout, elimination);
  EXPECT_EQ(system.by_schur(), expect_schur);
  system.assemble(s.r.data(), s.J.data(), pool);
  EXPECT_EQ(system.factorize(damping, pool), -1);
  EXPECT_GT(system.smallest_pivot_ratio(), 0.0);
  std::vector<double> x = system.gradient();
  system.solve(x.data());
  std::vector<double> by_block;
  for (int b = 0; b < static_cast<int>(s.layout.dims.size()); ++b) {
    by_block.insert(by_block.end(), x.begin() + system.start(b),
                    x.begin() + system.start(b) + system.dim(b));
  }
  return by_block;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0, size = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(a[i] - b[i]));
    size = std::max(size, std::abs(a[i]));
  }
  return largest / size;
}

TEST(Schur, EqualsThePlainFactorisation) {
  for (int dim : {2, 3}) {
    for (int seed = 1; seed <= 10; ++seed) {
      const System s = random_system(5 + 4 * seed, 60 * seed, dim, seed);
      const double damping = seed % 2 == 0 ? 0.0 : 0.1;
      const std::vector<double> plain = solve(s, Elimination::kPlain, damping, 1, false);
      const std::vector<double> schur = solve(s, Elimination::kSchur, damping, 1, true);
      EXPECT_LT(difference(plain, schur), 1e-9);
    }
  }
}

TEST(Schur, DoesNotDependOnThreads) {
  const System s = random_system(40, 2000, 3, 7);
  EXPECT_EQ(solve(s, Elimination::kSchur, 0.0, 1, true),
            solve(s, Elimination::kSchur, 0.0, 3, true));
}

TEST(Schur, IsChosenForManyLandmarksOnly) {
  solve(random_system(40, 2000, 3, 1), Elimination::kAutomatic, 0.0, 1, true);
  solve(random_system(40, 100, 3, 1), Elimination::kAutomatic, 0.0, 1, false);
  solve(random_system(900, 1000, 3, 1), Elimination::kAutomatic, 0.0, 1, false);
}

TEST(Schur, LeavesAreNotJoined) {
  const System s = random_system(30, 300, 3, 2);
  const BlockPattern pattern = s.layout.pattern();
  const std::vector<int> leaves = independent_blocks(pattern);
  EXPECT_GE(leaves.size(), 300u);
  for (const auto& [a, b] : pattern.edges) {
    EXPECT_FALSE(std::binary_search(leaves.begin(), leaves.end(), a) &&
                 std::binary_search(leaves.begin(), leaves.end(), b));
  }
}

TEST(Schur, NamesTheBlockThatIsSingular) {
  WorkerPool pool(1);
  ResidualLayout layout;
  layout.dims = {6, 3, 3};
  const int own[] = {0}, first[] = {0, 1}, second[] = {0, 2};
  layout.add(6, own, 1, true);
  layout.add(3, first, 2, true);
  layout.add(2, second, 2, true);  // two rows for three unknowns
  std::vector<double> r(layout.residual_size, 1.0), J(layout.jacobian_size);
  Random random(3);
  for (double& x : J) x = random.normal();
  NormalEquations system(layout, Elimination::kSchur);
  ASSERT_TRUE(system.by_schur());
  system.assemble(r.data(), J.data(), pool);
  const int failed = system.factorize(0.0, pool);
  const bool told = failed == 2 || system.smallest_pivot_ratio() < 1e-14;
  EXPECT_TRUE(told) << failed;
  EXPECT_EQ(system.factorize(1e-3, pool), -1);
}

TEST(Schur, RefusesAnInfinitePivotAsThePlainFactorDoes) {
  ResidualLayout layout;
  layout.dims = {3, 2};
  const int both[] = {0, 1}, own[] = {0};
  layout.add(3, own, 1, true);
  layout.add(2, both, 2, true);
  std::vector<double> r(layout.residual_size, 1.0), J(layout.jacobian_size, 0.5);
  J[0] = 1e200;  // its square is not finite
  J[4] = J[8] = J[18] = 1.0;
  WorkerPool pool(1);
  for (const Elimination elimination : {Elimination::kPlain, Elimination::kSchur}) {
    NormalEquations system(layout, elimination);
    system.assemble(r.data(), J.data(), pool);
    EXPECT_EQ(system.factorize(0.0, pool), 0) << system.by_schur();
  }
}

TEST(Schur, LeavesAloneAreSolvedToo) {
  WorkerPool pool(1);
  ResidualLayout layout;
  layout.dims = {2, 2};
  for (int b : {0, 1}) layout.add(2, &b, 1, true);
  const std::vector<double> r = {2, 4, 6, 8}, J = {1, 0, 0, 1, 2, 0, 0, 2};
  NormalEquations system(layout, Elimination::kSchur);
  system.assemble(r.data(), J.data(), pool);
  ASSERT_EQ(system.factorize(0.0, pool), -1);
  std::vector<double> x = system.gradient();
  system.solve(x.data());
  EXPECT_NEAR(x[system.start(0) + 1], 4.0, 1e-12);
  EXPECT_NEAR(x[system.start(1)], 3.0, 1e-12);
}

}  // namespace
}  // namespace hybrid
