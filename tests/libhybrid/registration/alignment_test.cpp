// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/registration/alignment.h"

#include <gtest/gtest.h>

#include "libhybrid/registration/detail/graph.h"
#include "libhybrid/registration/observability.h"
#include "libhybrid/solvers/alternating.h"
#include "tests/libhybrid/registration/clouds.h"

namespace hybrid {
namespace {

using testing::Random;

const MatchNoise kNoise{0.03, 0.1, 3.0};

TEST(TargetCloud, MatchIsTheLeastOfAllPointsAndTheOutlierState) {
  Random random(3);
  WorkerPool pool(1);
  for (LocalShape shape : {LocalShape::kPoint, LocalShape::kSurface, LocalShape::kCurve}) {
    const TargetCloud target(testing::bumpy_surface(300, 0.0, random), shape, pool);
    const MatchWeights weights(kNoise, shape);
    int outliers = 0;
    for (int trial = 0; trial < 300; ++trial) {
      const Eigen::Vector3d p = target.point(random.below(300)) + random.vector<3>(0.1);
      double least = kNoise.gate * kNoise.gate;
      int best = -1;
      for (int k = 0; k < 300; ++k) {
        const double distance = weights(p - target.point(k), target.direction(k));
        if (distance < least) {
          least = distance;
          best = k;
        }
      }
      double distance = 0.0;
      const int incumbent = random.below(301) - 1;
      EXPECT_EQ(target.match(p, kNoise, weights, incumbent, distance), best);
      EXPECT_DOUBLE_EQ(distance, least);
      outliers += best < 0;
    }
    EXPECT_GT(outliers, 5);
    EXPECT_LT(outliers, 295);
  }
}

TEST(TargetCloud, DirectionsAreNormalsOfASurfaceAndTangentsOfACurve) {
  Random random(4);
  WorkerPool pool(1);
  Points plane, line;
  for (int i = 0; i < 200; ++i) {
    plane.emplace_back(random.uniform(), random.uniform(), 0.5);
    line.emplace_back(0.01 * i, 0.0, 0.0);
  }
  const TargetCloud surface(plane, LocalShape::kSurface, pool);
  const TargetCloud curve(line, LocalShape::kCurve, pool);
  for (int i = 0; i < 200; ++i) {
    EXPECT_NEAR(std::abs(surface.direction(i).z()), 1.0, 1e-9);
    EXPECT_NEAR(std::abs(curve.direction(i).x()), 1.0, 1e-9);
  }
}

TEST(Alignment, ObjectiveNeverRisesAtFixedNoise) {
  for (int seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    WorkerPool pool(1);
    const auto shape = static_cast<LocalShape>(seed % 3);
    const TargetCloud target(testing::bumpy_surface(400, 0.01, random), shape, pool);
    SE3 T(random.vector<3>(0.1), SO3::exp(random.vector<3>(0.3)));
    Alignment alignment(testing::bumpy_surface(300, 0.01, random), target, {0.1, 0.2, 3.0}, pool);
    double last = 1e300;
    for (int pair = 0; pair < 15; ++pair) {
      const double matched = alignment.match(T);
      EXPECT_LE(matched, last * (1.0 + 1e-12));
      last = alignment.align(T, 2);
      EXPECT_LE(last, matched * (1.0 + 1e-12));
    }
  }
}

TEST(Alignment, AgreesWithTheHybridGraphWrittenOut) {
  Random random(5);
  WorkerPool pool(1);
  const Points cloud = testing::bumpy_surface(40, 0.0, random);
  const TargetCloud target(cloud, LocalShape::kSurface, pool);
  Points source = cloud;
  for (Eigen::Vector3d& p : source) p += random.vector<3>(0.01);
  source.push_back({5.0, 5.0, 5.0});
  const SE3 start(Eigen::Vector3d(0.02, -0.01, 0.03), SO3::exp(Eigen::Vector3d(0.02, 0.03, -0.02)));

  const MatchNoise noise{0.05, 0.1, 3.0};
  Alignment alignment(source, target, noise, pool);
  SE3 T = start;
  double reached = 0.0;
  for (int pair = 0; pair < 30; ++pair) {
    alignment.match(T);
    reached = alignment.align(T, 20);
  }

  const HybridGraph graph = registration_graph(source, target, noise);
  Estimate initial;
  initial.values.insert(Key('x', 0), start);
  for (std::size_t i = 0; i < source.size(); ++i) initial.assignment.set(Key('d', i), 40);
  AlternatingOptions options;
  options.relative_decrease = 1e-12;
  options.continuous.relative_decrease = 1e-14;
  const Estimate estimate = alternate(graph, initial, options).estimate;
  const SE3 X = estimate.values.at<SE3>(Key('x', 0));
  EXPECT_LT((T.inverse() * X).log().norm(), 1e-6);
  for (std::size_t i = 0; i < source.size(); ++i) {
    const int k = alignment.assignment()[i];
    EXPECT_EQ(estimate.assignment.at(Key('d', i)), k < 0 ? 40 : k);
  }
  const double normalizers = 1.5 * std::log(2.0 * M_PI) + std::log(0.05 * 0.1 * 0.1);
  EXPECT_NEAR(objective(graph, estimate.values, estimate.assignment),
              reached + static_cast<double>(source.size()) * normalizers, 1e-6);
}

TEST(Alignment, CovarianceIsTheInverseInformationOfTheFactors) {
  Random random(6);
  WorkerPool pool(1);
  const Points cloud = testing::bumpy_surface(60, 0.0, random);
  const TargetCloud target(cloud, LocalShape::kSurface, pool);
  const SE3 T(Eigen::Vector3d(1.0, 2.0, 3.0), SO3::exp(Eigen::Vector3d(0.3, -0.5, 0.4)));
  const Points source = testing::moved(T.inverse(), cloud);
  Alignment alignment(source, target, kNoise, pool);
  alignment.match(T);
  ASSERT_EQ(alignment.inliers(), 60);
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  const MatchWeights weights(kNoise, LocalShape::kSurface);
  for (int i = 0; i < 60; ++i) {
    Eigen::Matrix<double, 3, 6> J;
    const Eigen::Matrix3d R = T.rotation().matrix();
    J << R, -R * hat(source[i]);
    const int k = alignment.assignment()[i];
    const Eigen::Matrix3d W =
        weights.all * Eigen::Matrix3d::Identity() +
        weights.directed * target.direction(k) * target.direction(k).transpose();
    information += J.transpose() * W * J;
  }
  const Eigen::Matrix<double, 6, 6> expected = information.inverse();
  const auto covariance = covariance_of(alignment, T, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_LT((covariance - expected).norm(), 1e-9 * expected.norm());
}

}  // namespace
}  // namespace hybrid
