// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_alignment.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/cloud_worlds.h"

namespace hybrid {
namespace {

using testing::cloud_at;
using testing::cluttered_hall;

const Eigen::Vector3f kOrigin = Eigen::Vector3f::Zero();

TEST(CloudPoints, NormalsLookAtTheSensor) {
  std::mt19937 random(1);
  const auto points = cloud_points(cloud_at(cluttered_hall(), SE3(), random), kOrigin, 0.2);
  std::size_t known = 0;
  for (const CloudPoint& point : points) {
    if (!point.has_normal()) continue;
    ++known;
    EXPECT_NEAR(point.normal.norm(), 1, 1e-5);
    EXPECT_LE(point.normal.dot(point.position), 1e-3);
  }
  EXPECT_GT(known, points.size() / 3);
}

/// What rays of these elevations [rad] see of a wall at x = 4 m, with errors of ranges [m].
std::vector<Eigen::Vector3f> on_wall(const std::vector<double>& elevations, double sigma,
                                     std::mt19937& random) {
  std::normal_distribution<double> noise(0, sigma);
  std::vector<Eigen::Vector3f> out;
  for (const double up : elevations) {
    for (double around = -0.6; around < 0.6; around += 0.01) {
      const Eigen::Vector3d ray(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around),
                                std::sin(up));
      out.push_back(((4 / ray.x() + noise(random)) * ray).cast<float>());
    }
  }
  return out;
}

TEST(CloudPoints, OneRingTellsNoNormalHoweverNoisy) {
  std::mt19937 random(1);
  for (const double sigma : {0.0, 0.01, 0.03, 0.06}) {
    for (const CloudPoint& point : cloud_points(on_wall({0.2}, sigma, random), kOrigin, 0.15)) {
      EXPECT_FALSE(point.has_normal()) << sigma;
    }
  }
}

TEST(CloudPoints, LieOnThePlaneOfThoseAround) {
  std::mt19937 random(1);
  std::vector<double> elevations;
  for (double up = -0.4; up < 0.4; up += 0.02) elevations.push_back(up);
  constexpr double kSigma = 0.02, kSpacing = 0.05;  // hardly two points a cube
  double squares = 0;
  int count = 0;
  for (const CloudPoint& point :
       cloud_points(on_wall(elevations, kSigma, random), kOrigin, kSpacing)) {
    if (!point.has_normal()) continue;
    squares += std::pow(point.position.x() - 4, 2);
    ++count;
  }
  ASSERT_GT(count, 100);
  EXPECT_LT(std::sqrt(squares / count), 0.6 * kSigma);
}

TEST(CloudPoints, WhatIsNoPlaceIsLeftOut) {
  std::vector<Eigen::Vector3f> points(200, Eigen::Vector3f(1, 2, 3));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  points.emplace_back(nan, 0, 0);
  points.emplace_back(0, infinity, 0);
  points.emplace_back(1e30F, 0, 0);
  EXPECT_EQ(cloud_points(points, kOrigin, 0.1).size(), 1U);
  EXPECT_FALSE(cloud_points(points, kOrigin, 0.1).front().has_normal()) << "all at one place";
  EXPECT_EQ(cloud_points({}, kOrigin, 0.1).size(), 0U);
}

TEST(ReachOf, IsTheMedianDistance) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 101; ++i) points.emplace_back(static_cast<float>(i) / 10, 0, 0);
  EXPECT_NEAR(reach_of(points, kOrigin), 5, 0.2);
  EXPECT_EQ(reach_of({points.begin(), points.begin() + 50}, kOrigin), 0) << "too few";
}

TEST(CloudAlignment, FindsTheMotionBetweenTwoClouds) {
  std::mt19937 random(1);
  const SE3 truth(Eigen::Vector3d(0.3, -0.2, 0.1), SO3::exp(Eigen::Vector3d(0.02, -0.03, 0.06)));
  CloudSurfaces map(0.2);
  map.add(cloud_points(cloud_at(cluttered_hall(), SE3(), random), kOrigin, 0.2));
  const auto points = cloud_points(cloud_at(cluttered_hall(), truth, random), kOrigin, 0.2);
  const CloudAlignment found = align(points, map, SE3());
  const Eigen::Matrix<double, 6, 1> off = truth.between(found.pose).log();
  EXPECT_LT(off.head<3>().norm(), 0.02);
  EXPECT_LT(off.tail<3>().norm(), 0.004);
  EXPECT_GT(found.inliers, 0.7);
  EXPECT_LE(found.support, found.inliers);
  // Within what its covariance allows: chi-square of 6 degrees of freedom, in one of 10,000.
  EXPECT_LT(off.dot(alignment_covariance(found).ldlt().solve(off)), 28);
}

TEST(CloudAlignment, DoesNotTellThePlaceAlongATunnel) {
  std::mt19937 random(1);
  const testing::CloudWorld tunnel{{{-500, -3, -1}, {500, 3, 3}}, {}};
  CloudSurfaces map(0.2);
  map.add(cloud_points(cloud_at(tunnel, SE3(), random), kOrigin, 0.2));
  const auto points = cloud_points(cloud_at(tunnel, SE3(), random), kOrigin, 0.2);
  const Matrix6 P = alignment_covariance(align(points, map, SE3()));
  EXPECT_GT(std::sqrt(P(0, 0)), 0.05);
  EXPECT_LT(std::sqrt(P(1, 1)), 0.02);
  EXPECT_LT(std::sqrt(P(2, 2)), 0.02);
}

TEST(CloudAlignment, NothingIsMatchedWithNothing) {
  CloudSurfaces map(0.2);
  EXPECT_EQ(align({}, map, SE3()).inliers, 0);
  const std::vector<CloudPoint> one{{{1, 0, 0}, {1, 0, 0}}};
  EXPECT_EQ(align(one, map, SE3()).inliers, 0);
  map.add(std::vector<CloudPoint>{{{1, 0, 0}, {-1, 0, 0}}});
  EXPECT_TRUE(alignment_covariance(align({}, map, SE3())).allFinite());
  const std::vector<CloudPoint> far{{{1e8F, 0, 0}, {-1, 0, 0}}};
  EXPECT_TRUE(align(far, map, SE3()).information.allFinite());
}

TEST(CloudSurfaces, PointsOfOneSurfaceAreOne) {
  CloudSurfaces map(0.2);
  map.add({{{1, 0, 0}, {-1, 0, 0}}, {{1, 0.1F, 0}, {-1, 0, 0}}, {{1, 0.1F, 0}, {1, 0, 0}}});
  ASSERT_EQ(map.points().size(), 2U) << "front and back of a wall are two";
  EXPECT_NEAR(map.points()[0].position.y(), 0.05, 1e-6);
  const CloudPoint* near = map.nearest({1.1F, 0, 0}, {-1, 0, 0}, 0.4);
  ASSERT_NE(near, nullptr);
  EXPECT_LT(near->normal.x(), 0);
  EXPECT_EQ(map.nearest({1.3F, 0, 0}, {-1, 0, 0}, 0.2), nullptr);
  EXPECT_EQ(map.nearest({1.1F, 0, 0}, {0, 1, 0}, 0.4), nullptr);
}

}  // namespace
}  // namespace hybrid
