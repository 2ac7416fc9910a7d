// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "mrpt_plugins/mapping/robot_sightings.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/se2.h"

namespace hybrid {
namespace {

const Key kObserver{'x', 4}, kBefore{'x', 3};

/// Robot 1 drives a quarter of a circle of 1 m about the origin from (1, 0), in 2 s from time 10
/// on; robot 0 stands in the origin and sees it by its id -7.
struct Meeting {
  Values values;
  RobotMotion motion{kBefore, 10, 12, Eigen::Isometry3d::Identity(), {}};
  std::map<std::int64_t, std::size_t> robots{{-6, 0}, {-7, 1}};
  RobotSightings sightings;

  Meeting() {
    values.insert(kObserver, SE2());
    values.insert(kBefore, SE2(1, 0, M_PI / 2));
    Values turn;
    turn.insert(Key(), SE2(1, 0, M_PI / 2).inverse() * SE2(0, 1, M_PI));
    motion.motion = isometry_at(turn, Key());
    motion.covariance.setZero();
    motion.covariance.diagonal() << 0.04, 0.04, 0, 0, 0, 0.01;
  }
  void see(double time, double yaw, std::int64_t id = -7) {
    DetectionFrame frame;
    frame.is_3d = false;
    Detection d;
    d.range = 1;
    d.yaw = yaw;
    d.id = id;
    d.covariance.diagonal() << 0.01, 0.0001, 0;
    frame.detections = {d};
    sightings.take(0, kObserver, time, {frame}, robots);
  }
  std::vector<ContinuousFactorPtr> met() {
    return sightings.met(1, motion, values, false, [](Key) { return true; });
  }
};

TEST(RobotSightings, SeeTheRobotOnItsWayBetweenTwoKeyframes) {
  Meeting m;
  m.see(11, M_PI / 4);
  const auto factors = m.met();
  ASSERT_EQ(factors.size(), 1U);
  EXPECT_EQ(factors[0]->keys(), (std::vector<Key>{kObserver, kBefore}));
  EXPECT_NEAR(factors[0]->cost(m.values), 0, 1e-12);
  EXPECT_EQ(m.sightings.used(), 1U);
  EXPECT_TRUE(m.sightings.dropped().empty());
}

TEST(RobotSightings, TrustTheOdometryTheLessTheFartherItLeads) {
  const auto cost_of_a_range_off_by_a_decimetre = [](double time) {
    Meeting m;
    m.see(time, (time - 10) * M_PI / 4);
    const auto factors = m.met();
    m.values.data(m.values.slot(kObserver))[0] = 0.1 * std::cos((time - 10) * M_PI / 4);
    m.values.data(m.values.slot(kObserver))[1] = 0.1 * std::sin((time - 10) * M_PI / 4);
    return factors.at(0)->cost(m.values);
  };
  EXPECT_NEAR(cost_of_a_range_off_by_a_decimetre(10), 0.5, 1e-9);                // 0.01
  EXPECT_NEAR(cost_of_a_range_off_by_a_decimetre(11), 0.5 * 0.01 / 0.03, 1e-9);  // + 0.04 / 2
}

// However often it is seen on the way, where the way led is known no better than by odometry.
TEST(RobotSightings, OfOneMotionHaveItsNoiseInCommon) {
  for (const int times : {1, 2, 20}) {
    Meeting m;
    for (int i = 0; i < times; ++i) m.see(11, M_PI / 4);
    double cost = 0;
    const auto factors = m.met();
    EXPECT_EQ(m.sightings.used(), static_cast<std::size_t>(times));
    m.values.data(m.values.slot(kObserver))[0] = 0.1 * std::cos(M_PI / 4);
    m.values.data(m.values.slot(kObserver))[1] = 0.1 * std::sin(M_PI / 4);
    for (const auto& factor : factors) cost += factor->cost(m.values);
    EXPECT_NEAR(cost, 0.5 * 0.01 / (0.01 / times + 0.02), 1e-9) << times;
  }
}

TEST(RobotSightings, WaitForTheNextKeyframeOfTheOther) {
  Meeting m;
  m.see(12.5, 0.1);
  EXPECT_TRUE(m.met().empty());
  EXPECT_EQ(m.sightings.dropped().at("robot sighting dropped: after the log of that robot"), 1U);
  m.motion.from = 12;
  m.motion.to = 13;
  EXPECT_EQ(m.met().size(), 1U);
  EXPECT_TRUE(m.sightings.dropped().empty());
}

TEST(RobotSightings, OfNoUseAreCounted) {
  Meeting m;
  m.see(11, 0, -6);  // itself
  m.see(11, 0, 3);   // a landmark
  m.see(9, 0);       // before the first keyframe of the other
  m.see(11.5, 0);    // with a pose that is gone
  EXPECT_TRUE(m.sightings.met(1, m.motion, m.values, false, [](Key) { return false; }).empty());
  m.see(11.7, 0);
  m.sightings.miss(1, 12);  // without odometry
  const auto dropped = m.sightings.dropped();
  EXPECT_EQ(dropped.size(), 4U);
  EXPECT_EQ(dropped.at("robot sighting dropped: of the robot itself"), 1U);
  EXPECT_EQ(dropped.at("robot sighting dropped: before the log of that robot"), 1U);
  EXPECT_EQ(dropped.at("robot sighting dropped: its pose is marginalised out"), 1U);
  EXPECT_EQ(dropped.at("robot sighting dropped: no odometry of that robot"), 1U);
  EXPECT_EQ(m.sightings.used(), 0U);
}

}  // namespace
}  // namespace hybrid
