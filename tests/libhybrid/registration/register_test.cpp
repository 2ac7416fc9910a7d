// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/registration/register.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <filesystem>
#include <limits>

#include "libhybrid/core/error.h"
#include "libhybrid/io/read_points.h"
#include "tests/libhybrid/registration/clouds.h"
#include "tests/support/data_path.h"

namespace hybrid {
namespace {

using testing::Random;

constexpr double kDegree = M_PI / 180.0;

SE3 turn_about(const Eigen::Vector3d& center, const Eigen::Vector3d& rotation) {
  const SO3 R = SO3::exp(rotation);
  return {center - R * center, R};
}

TEST(Register, FindsAMotionOfOverlappingNoisyClouds) {
  Random random(1);
  const SE3 truth(Eigen::Vector3d(0.2, -0.1, 0.3), SO3::exp(Eigen::Vector3d(0.3, 0.2, -0.2)));
  Points source, target;
  for (const Eigen::Vector3d& p : testing::bumpy_surface(4000, 0.002, random)) {
    if (p.x() < 0.4) source.push_back(truth.inverse() * p);
  }
  for (const Eigen::Vector3d& p : testing::bumpy_surface(4000, 0.002, random)) {
    if (p.x() > -0.4) target.push_back(p);
  }
  const RegistrationResult result = register_clouds(source, target);
  ASSERT_EQ(result.status, RegistrationResult::Status::kConverged);
  const SE3 error = truth.inverse() * result.T_target_source;
  EXPECT_LT(testing::angle(error), 0.3 * kDegree);
  EXPECT_LT(error.translation().norm(), 0.005);
  const double share = result.inliers / static_cast<double>(source.size());
  EXPECT_GT(share, 0.3);
  EXPECT_LT(share, 0.8);
}

TEST(Register, EveryStageDescends) {
  Random random(2);
  const Points target = testing::bumpy_surface(3000, 0.002, random);
  const SE3 truth = turn_about({0.1, 0.2, 0.0}, {0.2, -0.3, 0.1});
  const RegistrationResult result = register_clouds(
      testing::moved(truth.inverse(), testing::bumpy_surface(3000, 0.002, random)), target);
  ASSERT_GT(result.stages.size(), 3u);
  for (const RegistrationStage& stage : result.stages) {
    for (std::size_t i = 1; i < stage.objectives.size(); ++i) {
      EXPECT_LE(stage.objectives[i], stage.objectives[i - 1] * (1.0 + 1e-12));
    }
  }
}

TEST(Register, ResultDoesNotDependOnThreads) {
  Random random(3);
  const Points target = testing::bumpy_surface(5000, 0.002, random);
  Points source = testing::bumpy_surface(5000, 0.002, random);
  source.resize(3000);
  RegistrationOptions options;
  options.convincing_share = 1.1;  // so that the other starts are tried
  options.threads = 1;
  const RegistrationResult one = register_clouds(source, target, options);
  options.threads = 3;
  const RegistrationResult three = register_clouds(source, target, options);
  EXPECT_EQ(one.T_target_source.matrix(), three.T_target_source.matrix());
  EXPECT_EQ(one.assignment, three.assignment);
  EXPECT_EQ(one.objective, three.objective);
  EXPECT_EQ(one.covariance, three.covariance);
  EXPECT_GT(one.starts, 1);
}

TEST(Register, WideBasin) {
  int successes = 0;
  for (int trial = 0; trial < 20; ++trial) {
    Random random(100 + trial);
    const Points target = testing::bumpy_surface(800, 0.003, random);
    const Eigen::Vector3d rotation = 40.0 * kDegree * random.vector<3>().normalized();
    const SE3 truth = turn_about(Eigen::Vector3d::Zero(), rotation);
    const Points source =
        testing::moved(truth.inverse(), testing::bumpy_surface(800, 0.003, random));
    const SE3 error = truth.inverse() * register_clouds(source, target).T_target_source;
    successes += testing::angle(error) < 2.0 * kDegree;
  }
  EXPECT_GE(successes, 19);
}

TEST(Register, CovarianceMatchesTheErrorOfTruePairs) {
  // With the points themselves as landmarks all noise is in the source: the error is normal.
  double sum = 0.0;
  constexpr int kTrials = 40;
  for (int trial = 0; trial < kTrials; ++trial) {
    Random random(200 + trial);
    const Points target = testing::bumpy_surface(200, 0.0, random);
    Points source = target;
    for (Eigen::Vector3d& p : source) p += random.vector<3>(0.002);
    RegistrationOptions options;
    options.metric = MatchMetric::kPoint;
    const RegistrationResult result = register_clouds(source, target, options);
    ASSERT_EQ(result.status, RegistrationResult::Status::kConverged);
    const SE3::Tangent error = result.T_target_source.log();
    sum += error.dot(result.covariance.inverse() * error);
  }
  EXPECT_GT(sum / kTrials, 6.0 * 0.6);
  EXPECT_LT(sum / kTrials, 6.0 * 1.6);
}

TEST(Register, RefusesBadClouds) {
  const Points good = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  EXPECT_THROW(register_clouds({}, good), Error);
  EXPECT_THROW(register_clouds(good, {{0, 0, 0}, {1, 0, 0}}), Error);
  Points bad = good;
  bad[2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(register_clouds(bad, good), Error);
  EXPECT_THROW(register_clouds(good, bad), Error);
}

TEST(Register, TinyAndCoincidentClouds) {
  const Points corners = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  RegistrationOptions options;
  options.metric = MatchMetric::kPoint;
  const RegistrationResult result = register_clouds(corners, corners, options);
  EXPECT_LT(result.T_target_source.log().norm(), 1e-6);
  EXPECT_EQ(result.inliers, 4);
  const Points same(50, Eigen::Vector3d(1, 2, 3));
  EXPECT_THROW(register_clouds(same, corners), Error);
  EXPECT_THROW(register_clouds(corners, same), Error);
  Points doubled = corners;
  for (int i = 0; i < 5; ++i) doubled.insert(doubled.end(), corners.begin(), corners.end());
  EXPECT_LT(register_clouds(doubled, doubled, options).T_target_source.log().norm(), 1e-6);
}

Eigen::Quaterniond about(const Eigen::Vector3d& axis, double degrees) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(degrees * kDegree, axis));
}

void expect_pair(const std::string& source, const std::string& target, const SE3& truth,
                 double degrees, double distance) {
  const auto file = [](const std::string& name) {
    return testing::data_path("pointclouds/" + name);
  };
  if (!std::filesystem::exists(file(source))) GTEST_SKIP() << source << " is not there";
  const RegistrationResult result =
      register_clouds(read_points(file(source)).points, read_points(file(target)).points);
  ASSERT_EQ(result.status, RegistrationResult::Status::kConverged);
  const SE3& T = result.T_target_source;
  EXPECT_LT(testing::angle(truth.inverse() * T), degrees * kDegree);
  EXPECT_LT((T.translation() - truth.translation()).norm(), distance);
}

TEST(Register, PublicDragon) {
  const Eigen::Quaterniond q = about(Eigen::Vector3d::UnitX(), 1) *
                               about(Eigen::Vector3d::UnitY(), 2) *
                               about(Eigen::Vector3d::UnitZ(), 3);
  expect_pair("dragon1.xyz", "dragon2.xyz", {{0.2, 0.4, 0.6}, q}, 0.01, 0.001);
}

TEST(Register, PublicBunny) {
  const SE3 truth(Eigen::Vector3d::Zero(), about(Eigen::Vector3d::UnitZ(), -10));
  expect_pair("bunny_part1.xyz", "bunny_part2.xyz", truth, 0.1, 0.05);
}

}  // namespace
}  // namespace hybrid
