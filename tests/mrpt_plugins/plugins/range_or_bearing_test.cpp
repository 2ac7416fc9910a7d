// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationBeaconRanges.h>

#include <cmath>
#include <random>
#include <tuple>

#include "libhybrid/factors/bearing.h"
#include "libhybrid/factors/range.h"
#include "libhybrid/initialization/gaussian_sum_initializer.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "tests/mrpt_plugins/plugins/beacon_world.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::make_mapper;
using World = testing::BeaconWorld;

void expect_beacons(const MapResult& result, const World& world, double tolerance) {
  ASSERT_EQ(result.landmarks.size(), world.beacons.size());
  for (const LandmarkEstimate& l : result.landmarks) {
    const Eigen::Vector3d& truth = world.beacons.at(static_cast<std::size_t>(l.id));
    EXPECT_LT((l.position - truth).norm(), tolerance) << l.id << ": " << l.position.transpose();
  }
}

class RangeOrBearing : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(PlaneAndSpace, RangeOrBearing, ::testing::Bool());

TEST_P(RangeOrBearing, BeaconsFindTheirPlacesFromRangesAlone) {
  World world(GetParam());
  Mapper mapper = make_mapper("BeaconRanges", GetParam());
  for (int i = 0; i < 40; ++i) mapper.add(world.with_ranges(i, 0));
  mapper.finish();
  // In space the robot rises by a metre only, which tells heights less well.
  expect_beacons(mapper.result(), world, GetParam() ? 0.5 : 0.2);
}

TEST_P(RangeOrBearing, LandmarksFindTheirDepthsAndClassesFromDirectionsAlone) {
  World world(GetParam());
  Mapper mapper = make_mapper("BearingOnlyKnownIds", GetParam());
  for (int i = 0; i < 40; ++i) mapper.add(world.with_bearings(i));
  mapper.finish();
  const MapResult result = mapper.result();
  // The odometry alone gives the scale.
  expect_beacons(result, world, 0.3);
  EXPECT_EQ(result.class_names, (std::vector<std::string>{"lamp", "door"}));
  for (const LandmarkEstimate& l : result.landmarks) EXPECT_EQ(l.class_index, l.id % 2);
}

TEST(BeaconRanges, HiddenIdentitiesAreFoundOut) {
  const auto error_with = [](double share) {
    World world(false);
    Mapper mapper = make_mapper("BeaconRanges", false);
    for (int i = 0; i < 60; ++i) mapper.add(world.with_ranges(i, share));
    mapper.finish();
    const MapResult result = mapper.result();
    expect_beacons(result, world, 0.25);
    double sum = 0;
    for (int i = 0; i < 60; ++i) {
      sum += std::pow(
          result.trajectory.at(static_cast<std::size_t>(i)).pose.distanceTo(world.true_pose(i)), 2);
    }
    return std::sqrt(sum / 60);
  };
  EXPECT_LT(error_with(0.5), 1.15 * error_with(0));
}

TEST(BeaconRanges, TellsWhichBeaconEveryHiddenRangeCameFrom) {
  World world(false);
  Mapper mapper = make_mapper("BeaconRanges", false);
  std::size_t hidden = 0;
  for (int i = 0; i < 60; ++i) {
    const Keyframe keyframe = world.with_ranges(i, 0.5);
    const auto& seen =
        dynamic_cast<const mrpt::obs::CObservationBeaconRanges&>(*keyframe.observations[0]);
    for (const auto& m : seen.sensedData) hidden += m.beaconID < 0 ? 1 : 0;
    mapper.add(keyframe);
  }
  EXPECT_LT(mapper.backend().assignment().size(), 60 * world.beacons.size());  // some still wait
  mapper.finish();
  const auto decisions = mapper.decisions();
  EXPECT_EQ(decisions.size(), hidden);
  std::size_t right = 0;
  for (const AssociationDecision& d : decisions) {
    EXPECT_LT(d.pose, 60U);
    EXPECT_FALSE(d.true_id);
    // A frame measures the beacons in the order of their ids.
    if (d.estimated_id == static_cast<std::int64_t>(d.measurement)) ++right;
  }
  EXPECT_GT(static_cast<double>(right), 0.95 * static_cast<double>(hidden));
}

/// The sensor takes one beacon for another at first; some ranges are to beacons that it does not
/// name, and are associated again with the beacon where it really is.
TEST_P(RangeOrBearing, ABeaconInTheWrongPlaceIsPlacedAgain) {
  World world(GetParam());
  Mapper mapper = make_mapper("BeaconRanges", GetParam());
  std::size_t hidden = 0;
  for (int i = 0; i < 60; ++i) {
    Keyframe keyframe = world.with_ranges(i, 0.2);
    auto& ranges =
        dynamic_cast<mrpt::obs::CObservationBeaconRanges&>(*keyframe.observations[0]).sensedData;
    for (const auto& m : ranges) hidden += m.beaconID < 0 ? 1 : 0;
    if (i < 20) ranges[0].sensedDistance = ranges[3].sensedDistance;
    mapper.add(keyframe);
    if (i != 19) continue;
    ASSERT_NE(mapper.landmarks().find(0), nullptr);
    const LandmarkEstimate early = mapper.result().landmarks.front();
    ASSERT_LT((early.position - world.beacons[3]).norm(), 2.0) << "not where it was to be";
  }
  mapper.finish();
  expect_beacons(mapper.result(), world, GetParam() ? 0.5 : 0.25);
  EXPECT_TRUE(mapper.warnings().empty());
  EXPECT_EQ(mapper.decisions().size(), hidden);
}

TEST(BeaconRanges, FalseRangesAreCountedOrFoundOut) {
  World world(false);
  Mapper mapper = make_mapper("BeaconRanges", false);
  for (int i = 0; i < 40; ++i) {
    Keyframe keyframe = world.with_ranges(i, 0);
    auto& ranges =
        dynamic_cast<mrpt::obs::CObservationBeaconRanges&>(*keyframe.observations[0]).sensedData;
    if (i % 7 == 3) ranges[1].sensedDistance += 15;
    if (i == 20) ranges[0].sensedDistance = 0;
    if (i == 21) ranges[0].sensedDistance = INFINITY;
    if (i == 22) ranges[0].sensedDistance = 1e7F;
    if (i == 23) ranges[0].sensedDistance = 1e4F;
    mapper.add(keyframe);
  }
  mapper.finish();
  expect_beacons(mapper.result(), world, 0.2);
  for (const char* why :
       {"range dropped: not positive", "range dropped: not finite", "range dropped: above limit"}) {
    EXPECT_EQ(mapper.dropped().at(why), 1U) << why;
  }
}

/// Something stands between the robot and a beacon for longer than an initialiser remembers: the
/// ranges of that time are false, and none of them moves the beacon.
TEST(BeaconRanges, ABeaconStaysWhileItsRangesAreLong) {
  World world(false);
  Mapper mapper = make_mapper("BeaconRanges", false);
  for (int i = 0; i < 300; ++i) {
    Keyframe keyframe = world.with_ranges(i, 0);
    auto& ranges =
        dynamic_cast<mrpt::obs::CObservationBeaconRanges&>(*keyframe.observations[0]).sensedData;
    if (i >= 150 && i < 260) ranges[0].sensedDistance += 0.2F * static_cast<float>(270 - i);
    mapper.add(keyframe);
    ASSERT_TRUE(i <= 40 || mapper.landmarks().find(0) != nullptr) << "keyframe " << i;
  }
  mapper.finish();
  expect_beacons(mapper.result(), world, 0.2);
}

TEST(BeaconRanges, WhatHasNoPlaceIsSaid) {
  World world(false);
  Mapper mapper = make_mapper("BeaconRanges", false);
  for (int i = 0; i < 3; ++i) mapper.add(world.with_ranges(i, 0));
  mapper.finish();
  EXPECT_TRUE(mapper.result().landmarks.empty());
  EXPECT_EQ(mapper.dropped().at(
                "range not used: its beacon has no place, since it was seen too few times"),
            3 * world.beacons.size());
}

/// A world ten times as large, with ranges of ten times the noise, comes to the same decisions.
TEST(GaussianSumInitializer, DecidesAtAnyScale) {
  for (const double scale : {0.1, 1.0, 100.0}) {
    BankOptions options;
    GaussianSumInitializer bank(ring_places(Eigen::Vector2d(0, 0), 5 * scale, 24));
    Values poses;
    const Eigen::Vector2d beacon(3 * scale, 4 * scale);
    std::size_t decided_at = 0;
    for (std::uint64_t i = 0; i < 12 && decided_at == 0; ++i) {
      const Eigen::Vector2d at(0.4 * scale * static_cast<double>(i),
                               0.05 * scale * static_cast<double>(i * i));
      poses.insert(Key('x', i), SE2(at, SO2(0.0)));
      const auto factor = std::make_shared<Range<SE2, Eigen::Vector2d>>(
          Key('x', i), Key('l', 0), (beacon - at).norm(), Noise::isotropic(1, 0.03 * scale));
      bank.add({factor, factor, 0.05 / scale}, options);
      bank.refine([&](Key key) { return poses.data(key); }, options);
      if (bank.decided(options)) decided_at = i + 1;
    }
    EXPECT_EQ(decided_at, 5u) << scale;
  }
}

/// On a straight line ranges cannot tell left from right: both places stay, none is taken.
TEST(GaussianSumInitializer, KeepsBothSidesOfAStraightWay) {
  BankOptions options;
  options.drift = 0;
  GaussianSumInitializer bank(ring_places(Eigen::Vector2d(0, 0), 5, 24));
  Values poses;
  const Eigen::Vector2d beacon(3, 4);
  for (int i = 0; i < 12; ++i) {
    const Key pose('x', static_cast<std::uint64_t>(i));
    poses.insert(pose, SE2(Eigen::Vector2d(0.5 * i, 0), SO2(0.0)));
    const double range = (beacon - Eigen::Vector2d(0.5 * i, 0)).norm();
    const auto factor = std::make_shared<Range<SE2, Eigen::Vector2d>>(pose, Key('l', 0), range,
                                                                      Noise::isotropic(1, 0.05));
    bank.add({factor, factor, 0.01}, options);
    bank.refine([&](Key key) { return poses.data(key); }, options);
  }
  EXPECT_FALSE(bank.decided(options));
  ASSERT_EQ(bank.places().size(), 2U);
  for (const auto& place : bank.places()) {
    EXPECT_NEAR(place.probability, 0.5, 0.01);
    EXPECT_NEAR(place.point.x(), 3, 0.05);
    EXPECT_NEAR(std::abs(place.point.y()), 4, 0.05);
  }
  // One step aside decides.
  poses.insert(Key('x', 99), SE2(Eigen::Vector2d(6, 2), SO2(0.0)));
  const auto aside = std::make_shared<Range<SE2, Eigen::Vector2d>>(
      Key('x', 99), Key('l', 0), (beacon - Eigen::Vector2d(6, 2)).norm(),
      Noise::isotropic(1, 0.05));
  bank.add({aside, aside, 0.01}, options);
  bank.add({aside, aside, 0.01}, options);
  bank.refine([&](Key key) { return poses.data(key); }, options);
  ASSERT_TRUE(bank.decided(options));
  EXPECT_NEAR(bank.decided(options)->y(), 4, 0.1);
}

/// A robot on a curve measures one landmark, some measurements false: the initialiser of a landmark
/// against trying all places.
struct OneLandmark {
  OneLandmark(bool by_range, double outliers, int seed)
      : random(static_cast<std::uint64_t>(seed)), landmark(random.vector<2>(6.0)) {
    std::vector<Eigen::VectorXd> first;
    SE2 x(0, 0, random.uniform(-3.0, 3.0));
    const double turn = random.uniform(0.05, 0.3);
    for (int i = 0; i < 12; ++i, x = x * SE2(0.6, 0.0, turn)) {
      const Key pose('x', static_cast<std::uint64_t>(i));
      poses.insert(pose, x);
      const Eigen::Vector2d seen = x.inverse() * landmark;
      const bool wrong = random.uniform() < outliers;
      double z = by_range ? seen.norm() : std::atan2(seen.y(), seen.x());
      z += random.normal(by_range ? 0.05 : 0.01);
      if (wrong) z = by_range ? random.uniform(0.1, kFarthest) : random.uniform(-M_PI, M_PI);
      ContinuousFactorPtr factor;
      if (by_range) {
        factor = std::make_shared<Range<SE2, Eigen::Vector2d>>(pose, Key('l', 0), z,
                                                               Noise::isotropic(1, 0.05));
      } else {
        factor = std::make_shared<Bearing2>(pose, Key('l', 0), Bearing2::Angles::Constant(z),
                                            Noise::isotropic(1, 0.01));
      }
      measurements.push_back({factor, factor, by_range ? 1 / kFarthest : 1 / (2 * M_PI)});
      const Eigen::Vector2d ray(std::cos(z + x.angle()), std::sin(z + x.angle()));
      candidates.push_back(by_range ? ring_places(x.translation(), z, 24)
                                    : ray_places(x.translation(), ray, 0.5, 100, 16));
    }
  }

  const double* pose(Key key) const { return poses.data(key); }
  double cost(const Eigen::Vector2d& point) const {
    return measurement_cost(
        measurements, point, [this](Key key) { return pose(key); }, kOutlierShare);
  }

  /// The least cost of all places within 25 m, by a grid and Newton-free descent from its best
  /// cells.
  double least_cost() const {
    std::vector<std::pair<double, Eigen::Vector2d>> cells;
    for (double px = -25; px <= 25; px += 0.25) {
      for (double py = -25; py <= 25; py += 0.25) {
        cells.emplace_back(cost({px, py}), Eigen::Vector2d(px, py));
      }
    }
    std::sort(cells.begin(), cells.end(), [](auto& a, auto& b) { return a.first < b.first; });
    double least = cells.front().first;
    for (int k = 0; k < 40; ++k) {
      auto [best, at] = cells[static_cast<std::size_t>(k)];
      for (double step = 0.2; step > 1e-5;) {
        bool moved = false;
        for (int d = 0; d < 8 && !moved; ++d) {
          const Eigen::Vector2d next =
              at + step * Eigen::Vector2d(std::cos(M_PI / 4 * d), std::sin(M_PI / 4 * d));
          const double c = cost(next);
          moved = c < best;
          if (moved) std::tie(best, at) = std::make_pair(c, next);
        }
        if (!moved) step *= 0.5;
      }
      least = std::min(least, best);
    }
    return least;
  }

  GaussianSumInitializer bank() {
    BankOptions options;
    options.outlier_share = kOutlierShare;
    GaussianSumInitializer bank(candidates.front());
    for (std::size_t i = 0; i < measurements.size(); ++i) {
      if (bank.needs_candidates()) bank.add_candidates(candidates[i]);
      bank.add(measurements[i], options);
      bank.refine([this](Key key) { return pose(key); }, options);
    }
    return bank;
  }

  static constexpr double kOutlierShare = 0.1;
  static constexpr double kFarthest = 30;
  hybrid::testing::Random random;
  Eigen::Vector2d landmark;
  Values poses;
  std::vector<GaussianSumInitializer::Measurement> measurements;
  std::vector<std::vector<Eigen::VectorXd>> candidates;
};

class Initialiser : public ::testing::TestWithParam<std::tuple<bool, double>> {};
INSTANTIATE_TEST_SUITE_P(RangeAndBearing, Initialiser,
                         ::testing::Combine(::testing::Bool(), ::testing::Values(0.0, 0.1, 0.3)));

TEST_P(Initialiser, FindsTheBestOfAllPlaces) {
  const auto [by_range, outliers] = GetParam();
  BankOptions options;
  int decided = 0, found = 0, right = 0;
  constexpr int kWorlds = 24;
  for (int seed = 1; seed <= kWorlds; ++seed) {
    OneLandmark world(by_range, outliers, seed);
    const GaussianSumInitializer bank = world.bank();
    const double cost = world.cost(bank.places().front().point);
    found += cost < world.least_cost() + 0.01 ? 1 : 0;
    const auto place = bank.decided(options);
    if (!place) continue;
    ++decided;
    const Eigen::Vector2d error = *place - world.landmark;
    const Eigen::MatrixXd& sigma = bank.places().front().covariance;
    right += error.dot(sigma.llt().solve(error)) < 16 ? 1 : 0;
  }
  EXPECT_GE(found, kWorlds - (outliers > 0.2 ? 3 : 1));
  EXPECT_GE(decided, kWorlds / 2);
  EXPECT_GE(right, decided - (outliers > 0.2 ? 2 : 1));
}

}  // namespace
}  // namespace hybrid
