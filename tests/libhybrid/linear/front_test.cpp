// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/front.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstdint>
#include <cstring>
#include <vector>

#include "libhybrid/linear/kernels/kernels.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;

Eigen::MatrixXd random_positive(int n, Random& random) {
  Eigen::MatrixXd a(n, n);
  for (int i = 0; i < n * n; ++i) a.data()[i] = random.normal();
  return a * a.transpose() + Eigen::MatrixXd::Identity(n, n);
}

void load(const Eigen::MatrixXd& a, Front& front) {
  front.reset(static_cast<int>(a.rows()));
  for (int j = 0; j < a.cols(); ++j) {
    for (int i = j; i < a.rows(); ++i) front(i, j) = a(i, j);
  }
}

TEST(Front, EqualsTheFactorOfEigenForAllSizes) {
  Random random(1);
  Front front;
  for (int n = 1; n <= 150; ++n) {
    const Eigen::MatrixXd a = random_positive(n, random);
    for (int f : {1, n / 3, n - 1, n}) {
      if (f < 1) continue;
      SCOPED_TRACE("order " + std::to_string(n) + ", eliminating " + std::to_string(f));
      load(a, front);
      ASSERT_EQ(front.factorize(f, 1e-13), -1);
      const Eigen::MatrixXd L = a.topLeftCorner(f, f).llt().matrixL();
      Eigen::MatrixXd below(n - f, f);
      if (f < n) {
        below = L.triangularView<Eigen::Lower>().solve(a.topRightCorner(f, n - f)).transpose();
      }
      const Eigen::MatrixXd schur = a.bottomRightCorner(n - f, n - f) - below * below.transpose();
      double error = 0.0;
      for (int j = 0; j < n; ++j) {
        for (int i = j; i < n; ++i) {
          const double expected = i < f ? L(i, j) : j < f ? below(i - f, j) : schur(i - f, j - f);
          error = std::max(error, std::abs(front(i, j) - expected));
        }
      }
      EXPECT_LT(error, 1e-11 * a.cwiseAbs().maxCoeff());
    }
  }
}

/// FNV-1a of all bits of a factor and of a dot product.
std::uint64_t hash_of(const Kernels& kernels) {
  std::uint64_t state = 1;
  const auto next = [&state] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11) / 9007199254740992.0;  // in [0, 1), exactly
  };
  constexpr int kOrder = 61;
  Front front(kernels);
  front.reset(kOrder);
  for (int j = 0; j < kOrder; ++j) {
    for (int i = j; i < kOrder; ++i) front(i, j) = next();
    front(j, j) += kOrder;
  }
  EXPECT_EQ(front.factorize(40, 1e-13), -1);
  std::vector<double> a, b;
  for (int i = 0; i < 101; ++i) {
    a.push_back(next());
    b.push_back(next());
  }
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  const auto add = [&hash](double x) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &x, sizeof bits);
    hash = (hash ^ bits) * 0x100000001b3ULL;
  };
  for (int j = 0; j < kOrder; ++j) {
    for (int i = j; i < kOrder; ++i) add(front(i, j));
  }
  add(kernels.dot(a.data(), b.data(), 101));
  return hash;
}

/// The same bits on every processor, whatever registers and instructions it has.
TEST(Front, RoundsTheSameEverywhere) {
  for (const Kernels* kernels : supported_kernels()) {
    EXPECT_EQ(hash_of(*kernels), 0xca134d1d1afd3089ULL) << kernels->name;
  }
}

TEST(Front, ReportsTheFirstColumnWithoutAPivot) {
  Random random(2);
  Front front;
  for (int n = 1; n <= 60; ++n) {
    const int bad = random.below(n);
    Eigen::MatrixXd a = random_positive(n, random);
    // Column `bad` is a combination of those before it, or zero where it is the first.
    const Eigen::VectorXd mix = Eigen::VectorXd::Ones(bad);
    a.row(bad).setZero();
    a.col(bad).setZero();
    a.row(bad).head(bad) = (a.topLeftCorner(bad, bad) * mix).transpose();
    a.col(bad).head(bad) = a.row(bad).head(bad).transpose();
    a(bad, bad) = a.row(bad).head(bad).dot(mix);
    load(a, front);
    EXPECT_EQ(front.factorize(n, 1e-13), bad) << "order " << n;
  }
}

TEST(Front, ReportsNotANumber) {
  Front front;
  Random random(3);
  Eigen::MatrixXd a = random_positive(9, random);
  a(5, 5) = std::nan("");
  load(a, front);
  EXPECT_EQ(front.factorize(9, 1e-13), 5);
}

TEST(Front, DotOfAnyLength) {
  Random random(4);
  for (int n = 0; n < 70; ++n) {
    Eigen::VectorXd a(n), b(n);
    for (int i = 0; i < n; ++i) {
      a[i] = random.normal();
      b[i] = random.normal();
    }
    EXPECT_NEAR(kernels().dot(a.data(), b.data(), n), a.dot(b), 1e-12);
  }
}

}  // namespace
}  // namespace hybrid
