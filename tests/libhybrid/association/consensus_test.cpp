// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/consensus.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace hybrid {
namespace {

/// Two maps of the same points, the second shifted as a whole by drift of sigma `drift`, each point
/// known to `sigma`. Pairs are all of the first with all of the second.
IdentityHypotheses two_maps(const std::vector<Eigen::Vector2d>& first,
                            const std::vector<Eigen::Vector2d>& second, double drift, double sigma,
                            double gain) {
  IdentityHypotheses h;
  h.dim = 2;
  for (std::size_t a = 0; a < first.size(); ++a) {
    for (std::size_t b = 0; b < second.size(); ++b) {
      h.a.push_back(static_cast<int>(a));
      h.b.push_back(100 + static_cast<int>(b));
      h.gain.push_back(gain);
    }
  }
  const int n = static_cast<int>(h.a.size());
  h.difference.resize(2 * n);
  h.covariance.resize(2 * n, 2 * n);
  for (int p = 0; p < n; ++p) {
    h.difference.segment<2>(2 * p) = first[h.a[p]] - second[h.b[p] - 100];
    for (int q = 0; q < n; ++q) {
      double c = drift * drift;
      if (h.a[p] == h.a[q]) c += sigma * sigma;
      if (h.b[p] == h.b[q]) c += sigma * sigma;
      h.covariance.block<2, 2>(2 * p, 2 * q) = c * Eigen::Matrix2d::Identity();
    }
  }
  return h;
}

const std::vector<Eigen::Vector2d> kPoints = {{0, 0}, {3, 1}, {7, -2}, {4, 6}};

std::vector<Eigen::Vector2d> shifted(std::vector<Eigen::Vector2d> points, double x, double y) {
  for (Eigen::Vector2d& p : points) p += Eigen::Vector2d(x, y);
  return points;
}

TEST(Consensus, FindsTheShiftThatAllAgreeAbout) {
  const auto h = two_maps(kPoints, shifted(kPoints, 4, -3), 5.0, 0.1, 5.0);
  const ConsensusSet set = decided_consensus(h, 0.999, 4.6);
  ASSERT_EQ(set.pairs.size(), 4u);
  for (int p : set.pairs) EXPECT_EQ(h.a[p] + 100, h.b[p]);
  EXPECT_LT(set.cost, -4.6);
}

TEST(Consensus, OnePairDoesNotCloseALoopUnderLargeDrift) {
  const auto h = two_maps({{0, 0}}, {{4, -3}}, 5.0, 0.1, 5.0);
  EXPECT_TRUE(decided_consensus(h, 0.999, 4.6).pairs.empty());
  const auto near = two_maps({{0, 0}}, {{0.1, 0}}, 0.1, 0.1, 5.0);
  EXPECT_EQ(decided_consensus(near, 0.999, 4.6).pairs.size(), 1u);
}

TEST(Consensus, EquallySpacedPointsLeaveTheShiftOpen) {
  const std::vector<Eigen::Vector2d> row = {{0, 0}, {5, 0}, {10, 0}, {15, 0}};
  const std::vector<Eigen::Vector2d> part = {{7, 0}, {12, 0}};
  const auto h = two_maps(part, row, 10.0, 0.1, 6.0);
  EXPECT_FALSE(consensus_sets(h, 0.999).empty());
  EXPECT_TRUE(decided_consensus(h, 0.999, 4.6).pairs.empty());
}

TEST(Consensus, CostIsTheJointEvidence) {
  const auto h = two_maps(kPoints, shifted(kPoints, 1, 1), 2.0, 0.1, 5.0);
  const ConsensusSet best = consensus_sets(h, 0.999).front();
  const int n = static_cast<int>(best.pairs.size());
  Eigen::VectorXd r(2 * n);
  Eigen::MatrixXd S(2 * n, 2 * n);
  double gain = 0;
  for (int i = 0; i < n; ++i) {
    gain += h.gain[best.pairs[i]];
    r.segment<2>(2 * i) = h.difference.segment<2>(2 * best.pairs[i]);
    for (int j = 0; j < n; ++j) {
      S.block<2, 2>(2 * i, 2 * j) = h.covariance.block<2, 2>(2 * best.pairs[i], 2 * best.pairs[j]);
    }
  }
  const double chi_square = r.dot(S.ldlt().solve(r));
  EXPECT_NEAR(best.chi_square, chi_square, 1e-6);
  EXPECT_NEAR(best.cost, 0.5 * chi_square + 0.5 * std::log((2 * M_PI * S).determinant()) - gain,
              1e-6);
}

TEST(Consensus, NoPairsNoSets) {
  IdentityHypotheses h;
  h.dim = 2;
  EXPECT_TRUE(decided_consensus(h, 0.99, 1.0).pairs.empty());
}

}  // namespace
}  // namespace hybrid
