// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/align_frames.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/libhybrid/maps/stored_maps.h"

namespace hybrid {
namespace {

constexpr double kFrameOdds = 1e4;

/// Points of a square or cube of 10 m in two frames, the second where T says, with errors; some of
/// the first are anywhere.
std::vector<CommonPoint> points(const Eigen::Isometry3d& T_first_second, int right, int wrong,
                                double sigma, bool is_3d, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> along(0, 10);
  std::normal_distribution<double> normal(0, sigma);
  const auto any = [&] {
    return Eigen::Vector3d(along(random), along(random), is_3d ? along(random) : 0.0);
  };
  std::vector<CommonPoint> out;
  for (int i = 0; i < right + wrong; ++i) {
    const Eigen::Vector3d p = any();
    Eigen::Vector3d seen = i < right ? T_first_second * p : any();
    for (int k = 0; k < (is_3d ? 3 : 2); ++k) seen[k] += normal(random);
    out.push_back({seen, p});
  }
  return out;
}

Eigen::Isometry3d in_space() {
  Eigen::Isometry3d T = motion(3, -2, 2.5);
  T.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  T.translation().z() = 4;
  return T;
}

TEST(AlignFrames, FindsTheMotionAmongWrongPoints) {
  for (const bool is_3d : {false, true}) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const Eigen::Isometry3d T = is_3d ? in_space() : motion(3, -2, 2.5);
      const auto found = align_frames(points(T, 30, 20, 0.1, is_3d, seed), is_3d, kFrameOdds);
      ASSERT_TRUE(found) << seed;
      const Eigen::Isometry3d off = T.inverse() * found->T_first_second;
      EXPECT_LT(Eigen::AngleAxisd(off.linear()).angle(), 0.05) << seed;
      const Eigen::Vector3d middle(5, 5, is_3d ? 5 : 0);
      EXPECT_LT((T * middle - found->T_first_second * middle).norm(), 0.15) << seed;
      EXPECT_GT(found->sigma, 0.05);
      EXPECT_LT(found->sigma, 0.25);
      EXPECT_GE(found->agreeing, 28U);
    }
  }
}

TEST(AlignFrames, ItsCovarianceIsThatOfOnePoint) {
  const auto found =
      align_frames(points(motion(3, -2, 2.5), 200, 0, 0.1, false, 1), false, kFrameOdds);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->covariance.rows(), 3);
  // At the middle of the points, 7 m from the origin, a position is known as well as one point.
  Eigen::Matrix<double, 2, 3> J;
  J << 1, 0, -5, 0, 1, 5;
  const Eigen::Matrix2d at_middle = J * found->covariance * J.transpose();
  EXPECT_NEAR(std::sqrt(at_middle(0, 0)), 0.1, 0.02);
  // The heading, as one point at the usual distance of 4 m tells it.
  EXPECT_NEAR(std::sqrt(found->covariance(2, 2)), 0.1 / std::sqrt(2 * 100 / 12.0), 0.006);
}

TEST(AlignFrames, PointsThatHaveNothingInCommonSayNothing) {
  for (const bool is_3d : {false, true}) {
    for (unsigned seed = 1; seed <= 50; ++seed) {
      for (const int n : {3, 5, 10, 100}) {
        EXPECT_FALSE(
            align_frames(points(motion(0, 0, 0), 0, n, 0.1, is_3d, seed), is_3d, kFrameOdds))
            << n << ", seed " << seed;
      }
    }
  }
}

TEST(AlignFrames, PointsInOnePlaceSayNothing) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0, 0.1);
  std::vector<CommonPoint> all;
  for (int i = 0; i < 100; ++i) {
    all.push_back({Eigen::Vector3d(1 + normal(random), 2 + normal(random), 0),
                   Eigen::Vector3d(5 + normal(random), normal(random), 0)});
  }
  EXPECT_FALSE(align_frames(all, false, kFrameOdds));
}

TEST(AlignFrames, TooFewPointsSayNothing) {
  const auto all = points(motion(3, -2, 2.5), 2, 0, 0.01, false, 1);
  EXPECT_FALSE(align_frames({}, false, kFrameOdds));
  EXPECT_FALSE(align_frames(all, false, kFrameOdds));
}

}  // namespace
}  // namespace hybrid
