// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/robot_sighting.h"

#include <gtest/gtest.h>

#include "libhybrid/factors/expect_jacobians.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::expect_jacobians;
using testing::Random;

const Key kObserver{'x', 1}, kSeen{'x', 2};

template <class Pose>
class RobotSightingTest : public ::testing::Test {
 protected:
  using Point = typename Pose::Point;
  static constexpr int kRows = Point::RowsAtCompileTime;
  Random random{11};
};

using Poses = ::testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(RobotSightingTest, Poses);

TYPED_TEST(RobotSightingTest, JacobiansAgreeWithNumericOnes) {
  using Point = typename TypeParam::Point;
  for (int trial = 0; trial < 20; ++trial) {
    Point z = this->random.template vector<TestFixture::kRows>();
    z[0] = this->random.uniform(0.5, 5.0);
    const RobotSighting<TypeParam> factor(kObserver, kSeen, z, this->random.noise(this->kRows),
                                          this->random.template value<TypeParam>(),
                                          this->random.template value<Point>());
    Values values;
    values.insert(kObserver, this->random.template value<TypeParam>());
    values.insert(kSeen, TypeParam::exp(3 * this->random.template value<TypeParam>().log()));
    expect_jacobians(factor, values, 1e-6);
  }
}

TEST(RobotSighting, SeesThePointThatTheOtherCarries) {
  // The observer stands at (1, 0) and looks along y; the other faces -x and carries its mark 0.5 m
  // behind, at (1, 3).
  Values values;
  values.insert(kObserver, SE2(1, 0, M_PI / 2));
  values.insert(kSeen, SE2(0.5, 3, M_PI));
  const Noise noise = Noise::isotropic(2, 0.1);
  const RobotSighting2 right(kObserver, kSeen, {3, 0}, noise, SE2(), {-0.5, 0});
  EXPECT_NEAR(right.cost(values), 0, 1e-12);
  const RobotSighting2 off(kObserver, kSeen, {3.1, 0}, noise, SE2(), {-0.5, 0});
  EXPECT_NEAR(off.cost(values), 0.5, 1e-9);
}

TEST(RobotSighting, RefusesWhatIsNoMeasurement) {
  const Noise noise = Noise::isotropic(2, 0.1);
  EXPECT_THROW(RobotSighting2(kObserver, kSeen, {-1, 0}, noise), Error);
  EXPECT_THROW(RobotSighting2(kObserver, kSeen, {1, NAN}, noise), Error);
  EXPECT_THROW(RobotSighting2(kObserver, kSeen, {1, 0}, noise, SE2(), {NAN, 0}), Error);
}

}  // namespace
}  // namespace hybrid
