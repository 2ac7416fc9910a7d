// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_mapper.h"

#include <gtest/gtest.h>

#include "tests/support/cloud_worlds.h"

namespace hybrid {
namespace {

using testing::cloud_at;
using testing::cluttered_hall;
using testing::way_around_hall;

const Eigen::Vector3f kHere = Eigen::Vector3f::Zero();

/// A motion by odometry of which the heading drifts.
UncertainMotion3 drifting(const SE3& a, const SE3& b) {
  const SE3 drift(Eigen::Vector3d(0.02, 0, 0), SO3::exp(Eigen::Vector3d(0, 0, 0.01)));
  Eigen::Matrix<double, 6, 1> sigmas;
  sigmas << 0.04, 0.04, 0.04, 0.02, 0.02, 0.02;
  return {a.between(b) * drift, sigmas.cwiseAbs2().asDiagonal()};
}

double worst_error(const CloudMapper& mapper, const std::vector<SE3>& way) {
  double worst = 0;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const SE3 off = way[0].between(way[i]).between(mapper.pose(i));
    worst = std::max(worst, off.translation().norm());
  }
  return worst;
}

/// Maps the cluttered hall along a way, with odometry that drifts.
void drive(const std::vector<SE3>& way, CloudMapper& mapper) {
  std::mt19937 random(3);
  for (std::size_t i = 0; i < way.size(); ++i) {
    std::optional<UncertainMotion3> odometry;
    if (i > 0) odometry = drifting(way[i - 1], way[i]);
    mapper.add(cloud_at(cluttered_hall(), way[i], random), kHere, odometry);
  }
  mapper.finish();
}

TEST(CloudMapper, ClosesALoopInSpace) {
  const std::vector<SE3> way = way_around_hall(0.4);
  CloudMapperOptions options;
  options.tracker.map_length = 1;  // of 5 m, so that there are several local maps
  CloudMapper mapper(options);
  drive(way, mapper);
  EXPECT_EQ(mapper.tracker().lost(), 0U);
  EXPECT_LT(worst_error(mapper, way), 0.1);
  int accepted = 0;
  for (std::size_t k = 0; k < mapper.closures().size(); ++k) {
    if (mapper.status(k) != ClosureStatus::kAccepted) continue;
    ++accepted;
    const CloudClosure& c = mapper.closures()[k];
    const SE3 off = way[c.from].between(way[c.to]).between(c.pose.motion);
    EXPECT_LT(off.translation().norm(), 0.2) << c.from << " to " << c.to;
  }
  EXPECT_GT(accepted, 0);
}

// Before it sets off, the sensor sees the robot itself.
TEST(CloudMapper, LearnsTheReachFromCloudsThatSeeTheWorld) {
  const std::vector<SE3> way = way_around_hall(0.4);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> near(-0.3F, 0.3F);
  CloudMapper mapper;
  for (std::size_t i = 0; i < 40; ++i) {
    std::vector<Eigen::Vector3f> points;
    for (int k = 0; i < 2 && k < 300; ++k) points.emplace_back(near(random), near(random), 0.2F);
    if (i >= 2) points = cloud_at(cluttered_hall(), way[i], random);
    std::optional<UncertainMotion3> odometry;
    if (i > 0) odometry = drifting(way[i - 1], way[i]);
    mapper.add(points, kHere, odometry);
  }
  EXPECT_GT(mapper.tracker().reach(), 2);
  EXPECT_LE(mapper.tracker().lost(), 2U);
  const SE3 off = way[2].between(way[39]).between(mapper.pose(2).between(mapper.pose(39)));
  EXPECT_LT(off.translation().norm(), 0.1);
}

/// Each pair is tried once, and is the pair of the closure that is found; what is not tried is
/// counted by reason.
TEST(CloudMapper, ClosuresOfOthersAreTriedOnce) {
  const std::vector<SE3> way = way_around_hall(0.4);
  const std::size_t last = way.size() - 1;
  const auto proposed = [&](std::size_t from, std::size_t to) {
    return ProposedClosure{from, to, way[from].between(way[to])};
  };
  CloudMapperOptions options;
  options.tracker.map_length = 1;
  options.closures.most_maps = 0;
  ProposedClosure wrong = proposed(4, last - 3);
  wrong.pose = SE3({30, 30, 0}, SO3());  // outside of the hall
  options.closures.proposed = {
      proposed(2, last - 13), proposed(2, last - 13), proposed(3, last - 13), wrong,
      proposed(20, 23),       proposed(30, 38),       proposed(1, last + 1)};
  CloudMapper mapper(options);
  drive(way, mapper);
  ASSERT_EQ(mapper.closures().size(), 1U);
  const CloudClosure& closure = mapper.closures()[0];
  EXPECT_EQ(closure.from, 2U);
  EXPECT_EQ(closure.to, last - 13);
  const SE3 off = way[closure.from].between(way[closure.to]).between(closure.pose.motion);
  EXPECT_LT(off.translation().norm(), 0.1);
  const ProposedCount count = mapper.proposed();
  EXPECT_EQ(count.matched, 1U);
  EXPECT_EQ(count.same, 1U);
  EXPECT_EQ(count.unmatched, 1U);
  EXPECT_EQ(count.near, 2U) << "what both have seen fits itself";
  EXPECT_EQ(count.repeated, 1U);
  EXPECT_EQ(count.absent, 1U);
  EXPECT_EQ(count.blind, 0U);
}

TEST(CloudMapper, FollowsCloudsWithoutOdometry) {
  const std::vector<SE3> way = way_around_hall(0.4);
  CloudMapper mapper;
  std::mt19937 random(5);
  for (const SE3& pose : way) mapper.add(cloud_at(cluttered_hall(), pose, random), kHere);
  EXPECT_LT(worst_error(mapper, way), 0.15);
}

TEST(CloudMapper, CloudsThatTellNothingAreBridged) {
  const std::vector<SE3> way = way_around_hall(0.4);
  CloudMapper mapper;
  std::mt19937 random(5);
  const std::vector<Eigen::Vector3f> few(5, Eigen::Vector3f(1, 1, 1));
  for (std::size_t i = 0; i < 30; ++i) {
    std::optional<UncertainMotion3> odometry;
    if (i > 0) {
      odometry = UncertainMotion3{way[i - 1].between(way[i]), 1e-4 * Matrix6::Identity()};
    }
    const bool is_bad = i < 2 || i % 7 == 3;
    const auto seen = i % 2 == 0 ? few : std::vector<Eigen::Vector3f>();
    mapper.add(is_bad ? seen : cloud_at(cluttered_hall(), way[i], random), kHere, odometry);
  }
  mapper.finish();
  for (std::size_t i = 0; i < 30; ++i) {
    const SE3 off = way[0].between(way[i]).between(mapper.pose(i));
    EXPECT_LT(off.translation().norm(), 0.1) << i;
  }
}

const testing::CloudWorld kElsewhere{{{-3, -2, -1}, {4, 9, 2}}, {{{1, 1, -1}, {2, 3, 1}}}};

TEST(CloudMapper, CloudsOfAnotherPlaceBeginAMapOfTheirOwn) {
  CloudMapper mapper;
  std::mt19937 random(5);
  for (int i = 0; i < 3; ++i) mapper.add(cloud_at(cluttered_hall(), SE3(), random), kHere);
  EXPECT_TRUE(mapper.add(cloud_at(kElsewhere, SE3(), random), kHere).is_lost);
  EXPECT_TRUE(mapper.add(cloud_at(kElsewhere, SE3(), random), kHere).is_lost);
  EXPECT_FALSE(mapper.add(cloud_at(kElsewhere, SE3(), random), kHere).is_lost);
  EXPECT_EQ(mapper.tracker().local_maps().size(), 2U);
  mapper.finish();
}

TEST(CloudMapper, CloudsOfAnotherSensorInBetweenDoNoHarm) {
  const std::vector<SE3> way = way_around_hall(0.4);
  CloudMapper mapper;
  std::mt19937 random(5);
  std::vector<std::size_t> own;
  for (std::size_t i = 0; i < 40; ++i) {
    own.push_back(mapper.tracker().clouds());
    std::optional<UncertainMotion3> odometry;
    if (i > 0) odometry = drifting(way[i - 1], way[i]);
    mapper.add(cloud_at(cluttered_hall(), way[i], random), kHere, odometry);
    const UncertainMotion3 none{SE3(), 1e-6 * Matrix6::Identity()};
    if (i % 3 == 2) mapper.add(cloud_at(kElsewhere, SE3(), random), kHere, none);
  }
  mapper.finish();
  EXPECT_EQ(mapper.tracker().lost(), 13U);
  EXPECT_EQ(mapper.tracker().local_maps().size(), 1U);
  for (std::size_t i = 0; i < 40; ++i) {
    const SE3 off = way[0].between(way[i]).between(mapper.pose(own[i]));
    EXPECT_LT(off.translation().norm(), 0.1) << i;
  }
}

TEST(CloudMapper, GivesTheSameResultTwice) {
  const std::vector<SE3> way = way_around_hall(1);
  std::vector<double> ends;
  for (int run = 0; run < 2; ++run) {
    CloudMapper mapper;
    std::mt19937 random(2);
    for (const SE3& pose : way) mapper.add(cloud_at(cluttered_hall(), pose, random), kHere);
    mapper.finish();
    ends.push_back(mapper.pose(way.size() - 1).translation().x());
  }
  EXPECT_EQ(ends[0], ends[1]);
}

}  // namespace
}  // namespace hybrid
