// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include "libhybrid/core/error.h"
#include "libhybrid/registration/register.h"
#include "tests/libhybrid/registration/clouds.h"

namespace hybrid {
namespace {

using testing::Random;
using Status = RegistrationResult::Status;

int translations(const RegistrationResult& result) {
  int count = 0;
  for (const FreeMotion& motion : result.free_motions) count += !motion.is_rotation;
  return count;
}

TEST(Degenerate, LinesLeaveTheTurnAboutThemselvesFree) {
  Random random(1);
  Points source, target;
  const Eigen::Vector3d direction = Eigen::Vector3d(1, 2, 2) / 3.0;
  for (int i = 0; i < 100; ++i) {
    target.push_back(Eigen::Vector3d(1, 1, 1) + random.uniform(0, 3) * direction);
    source.push_back(target.back() + Eigen::Vector3d(0.02, 0.01, 0.0));
  }
  const RegistrationResult result = register_clouds(source, target);
  ASSERT_EQ(result.status, Status::kUnobservable);
  ASSERT_EQ(result.free_motions.size(), 1u);
  const FreeMotion& motion = result.free_motions[0];
  EXPECT_TRUE(motion.is_rotation);
  EXPECT_NEAR(std::abs(motion.direction.dot(direction)), 1.0, 1e-6);
  EXPECT_LT((motion.through - Eigen::Vector3d(1, 1, 1)).cross(direction).norm(), 1e-3);
  EXPECT_TRUE(result.covariance.isZero());
  EXPECT_TRUE(result.T_target_source.matrix().allFinite());
}

TEST(Degenerate, PlanesSlideAndTurn) {
  Random random(2);
  Points source, target;
  for (int i = 0; i < 1000; ++i) {
    source.emplace_back(random.uniform(), random.uniform(), 0.3);
    target.emplace_back(random.uniform(), random.uniform(), 0.32 + random.normal(1e-3));
  }
  for (const Points& cloud : {target, source}) {
    const RegistrationResult result = register_clouds(source, cloud);
    ASSERT_EQ(result.status, Status::kUnobservable);
    ASSERT_EQ(result.free_motions.size(), 3u);
    EXPECT_EQ(translations(result), 2);
    EXPECT_NEAR(std::abs(result.free_motions[2].direction.z()), 1.0, 1e-3);
  }
}

TEST(Degenerate, CylindersSlideAndTurnAboutTheirAxis) {
  Random random(3);
  const auto cylinder = [&] {
    Points points;
    for (int i = 0; i < 3000; ++i) {
      const double angle = random.uniform(0, 2 * M_PI);
      points.emplace_back(std::cos(angle), std::sin(angle), random.uniform(-2, 2));
    }
    return points;
  };
  const RegistrationResult result = register_clouds(cylinder(), cylinder());
  ASSERT_EQ(result.status, Status::kUnobservable);
  ASSERT_EQ(result.free_motions.size(), 2u);
  EXPECT_EQ(translations(result), 1);
  for (const FreeMotion& motion : result.free_motions) {
    EXPECT_GT(std::abs(motion.direction.z()), 0.99);
  }
  EXPECT_EQ(to_string(result.free_motions[0]).substr(0, 11), "translation");
}

TEST(Degenerate, SpheresTurnFreely) {
  Random random(4);
  const auto sphere = [&] {
    Points points;
    for (int i = 0; i < 3000; ++i) points.push_back(random.vector<3>().normalized());
    return points;
  };
  const RegistrationResult result = register_clouds(sphere(), sphere());
  ASSERT_EQ(result.status, Status::kUnobservable);
  EXPECT_EQ(result.free_motions.size(), 3u);
  EXPECT_EQ(translations(result), 0);
}

TEST(Degenerate, PlaneScansOfARoomAreDetermined) {
  Random random(5);
  const auto room = [&](int count) {
    Points points;  // an L-shaped room
    const Eigen::Vector2d corners[] = {{0, 0}, {6, 0}, {6, 2}, {3, 2}, {3, 5}, {0, 5}, {0, 0}};
    for (int i = 0; i < count; ++i) {
      const int wall = random.below(6);
      const Eigen::Vector2d p =
          corners[wall] + random.uniform() * (corners[wall + 1] - corners[wall]);
      points.emplace_back(p.x() + random.normal(0.005), p.y() + random.normal(0.005), 0.0);
    }
    return points;
  };
  const SE3 truth(Eigen::Vector3d(0.5, -0.3, 0), SO3::exp(Eigen::Vector3d(0, 0, 0.4)));
  const RegistrationResult result =
      register_clouds(testing::moved(truth.inverse(), room(700)), room(700));
  EXPECT_EQ(result.shape, LocalShape::kCurve);
  ASSERT_EQ(result.status, Status::kConverged);
  const SE3 error = truth.inverse() * result.T_target_source;
  EXPECT_LT(testing::angle(error), 0.01);
  EXPECT_LT(error.translation().norm(), 0.02);
}

TEST(Degenerate, CorridorsSlide) {
  Random random(6);
  const auto corridor = [&] {
    Points points;
    for (int i = 0; i < 600; ++i) {
      points.emplace_back(random.uniform(0, 8), i % 2 == 0 ? 0.0 : 2.0, 0.0);
    }
    return points;
  };
  const RegistrationResult result = register_clouds(corridor(), corridor());
  ASSERT_EQ(result.status, Status::kUnobservable);
  ASSERT_EQ(result.free_motions.size(), 1u);
  EXPECT_FALSE(result.free_motions[0].is_rotation);
  EXPECT_NEAR(std::abs(result.free_motions[0].direction.x()), 1.0, 1e-3);
}

TEST(Degenerate, CloudsFarApartFindEachOther) {
  Random random(7);
  const Points target = testing::bumpy_surface(1000, 0.001, random);
  const SE3 far(Eigen::Vector3d(100, 50, -30), SO3());
  const RegistrationResult result = register_clouds(
      testing::moved(far.inverse(), testing::bumpy_surface(1000, 0.001, random)), target);
  ASSERT_EQ(result.status, Status::kConverged);
  EXPECT_LT((result.T_target_source.translation() - far.translation()).norm(), 2.0);
  RegistrationOptions options;
  options.convincing_share = 0.0;
  const RegistrationResult none =
      register_clouds(testing::moved(far.inverse(), target), target, options);
  EXPECT_EQ(none.status, Status::kNoMatch);
}

TEST(Degenerate, AnExtentThatIsLostFarFromTheOriginIsNotCalledAPoint) {
  Random random(9);
  Points near, far;
  for (int i = 0; i < 100; ++i) {
    near.emplace_back(random.uniform(0, 3), random.uniform(0, 3), random.uniform(0, 3));
    far.push_back(near.back() + Eigen::Vector3d(1e8, 1e8, 0));
  }
  const auto message = [&](const Points& source) -> std::string {
    try {
      register_clouds(source, near);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(message(far).find("the source cloud: its extent of "), std::string::npos);
  EXPECT_NE(message(far).find("from the origin"), std::string::npos) << message(far);
  const Points same(10, Eigen::Vector3d(1e8, 1e8, 0)), zero(10, Eigen::Vector3d::Zero());
  EXPECT_NE(message(same).find("all its points coincide"), std::string::npos) << message(same);
  EXPECT_NE(message(zero).find("all its points coincide"), std::string::npos) << message(zero);
}

}  // namespace
}  // namespace hybrid
