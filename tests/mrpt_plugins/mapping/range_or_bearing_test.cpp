// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationBeaconRanges.h>

#include <cmath>
#include <random>

#include "libhybrid/factors/range.h"
#include "mrpt_plugins/mapping/hypothesis_bank.h"
#include "mrpt_plugins/mapping/mapper.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

/// A robot that drives a curve among four beacons; what it measures has the noise it states.
struct World {
  bool is_3d;
  std::mt19937 random{5};
  std::vector<Eigen::Vector3d> beacons;

  explicit World(bool in_space) : is_3d(in_space) {
    const double h = is_3d ? 1.0 : 0.0;
    beacons = {{6, 1, h}, {-3, 7, -2 * h}, {2, -6, 3 * h}, {9, 8, -h}};
  }
  double gauss(double sigma) { return sigma * std::normal_distribution<double>()(random); }

  CPose3D true_pose(int i) const {
    const double a = 0.15 * i;
    return {4 * std::sin(a), 4 - 4 * std::cos(a), is_3d ? std::sin(2 * a) : 0.0, a, 0, 0};
  }

  Keyframe keyframe(int i) {
    Keyframe out;
    out.row = static_cast<std::size_t>(i);
    out.time = i;
    if (i == 0) return out;
    OdometryIncrement odometry;
    odometry.mean =
        (true_pose(i) - true_pose(i - 1)) + CPose3D(gauss(0.02), gauss(0.02), 0, gauss(0.01), 0, 0);
    odometry.is_planar = !is_3d;
    odometry.covariance.diagonal() << 4e-4, 4e-4, 4e-4, 1e-4, 1e-4, 1e-4;
    out.odometry = odometry;
    return out;
  }

  Keyframe with_ranges(int i, double unknown_share) {
    Keyframe out = keyframe(i);
    auto seen = mrpt::obs::CObservationBeaconRanges::Create();
    seen->stdError = 0.05F;
    for (std::size_t id = 0; id < beacons.size(); ++id) {
      mrpt::obs::CObservationBeaconRanges::TMeasurement m;
      m.sensorLocationOnRobot = {0.1, 0, 0};
      const auto antenna = true_pose(i).composePoint({0.1, 0, 0});
      const double distance =
          (beacons[id] - Eigen::Vector3d(antenna.x, antenna.y, antenna.z)).norm();
      m.sensedDistance = static_cast<float>(distance + gauss(0.05));
      const bool hidden = std::uniform_real_distribution<double>()(random) < unknown_share;
      m.beaconID = hidden ? mrpt::obs::INVALID_BEACON_ID : static_cast<std::int32_t>(id);
      seen->sensedData.push_back(m);
    }
    out.observations = {seen};
    return out;
  }

  Keyframe with_bearings(int i) {
    Keyframe out = keyframe(i);
    DetectionFrame frame;
    frame.is_3d = is_3d;
    frame.has_range = false;
    frame.class_names = {"lamp", "door"};
    for (std::size_t id = 0; id < beacons.size(); ++id) {
      Detection d;
      true_pose(i).sphericalCoordinates({beacons[id].x(), beacons[id].y(), beacons[id].z()},
                                        d.range, d.yaw, d.pitch);
      d.range = 0;
      d.yaw += gauss(0.01);
      d.pitch = is_3d ? d.pitch + gauss(0.01) : 0.0;
      d.id = static_cast<std::int64_t>(id);
      d.class_probabilities =
          id % 2 == 0 ? std::vector<double>{0.7, 0.3} : std::vector<double>{0.2, 0.8};
      d.covariance.diagonal() << 1, 1e-4, is_3d ? 1e-4 : 0.0;
      frame.detections.push_back(d);
    }
    out.detections = {frame};
    return out;
  }
};

Mapper make_mapper(const std::string& plugin, bool is_3d) {
  IniFile ini;
  return {read_motion_options(ini),
          {make_plugin(plugin, ini)},
          make_backend(ini.section("solver")),
          is_3d};
}

void expect_beacons(const MapResult& result, const World& world, double tolerance) {
  ASSERT_EQ(result.landmarks.size(), world.beacons.size());
  for (const LandmarkEstimate& l : result.landmarks) {
    const Eigen::Vector3d& truth = world.beacons.at(static_cast<std::size_t>(l.id));
    EXPECT_LT((l.position - truth).norm(), tolerance) << l.id << ": " << l.position.transpose();
  }
}

class RangeOrBearing : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(PlaneAndSpace, RangeOrBearing, testing::Bool());

TEST_P(RangeOrBearing, BeaconsFindTheirPlacesFromRangesAlone) {
  World world(GetParam());
  Mapper mapper = make_mapper("BeaconRanges", GetParam());
  for (int i = 0; i < 40; ++i) mapper.add(world.with_ranges(i, 0));
  mapper.finish();
  // In space the robot rises by a metre only, which tells heights less well.
  expect_beacons(mapper.result(), world, GetParam() ? 0.5 : 0.15);
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
    expect_beacons(result, world, 0.2);
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
    if (i == 22) ranges[0].sensedDistance = 1e4F;
    mapper.add(keyframe);
  }
  mapper.finish();
  expect_beacons(mapper.result(), world, 0.15);
  for (const char* why :
       {"range dropped: not positive", "range dropped: not finite", "range dropped: above limit"}) {
    EXPECT_EQ(mapper.dropped().at(why), 1U) << why;
  }
}

/// On a straight line ranges cannot tell left from right: both places stay, none is taken.
TEST(HypothesisBank, KeepsBothSidesOfAStraightWay) {
  BankOptions options;
  options.drift = 0;
  HypothesisBank bank(ring_places(Eigen::Vector2d(0, 0), 5, 24));
  Values poses;
  const Eigen::Vector2d beacon(3, 4);
  for (int i = 0; i < 12; ++i) {
    const Key pose('x', static_cast<std::uint64_t>(i));
    poses.insert(pose, SE2(Eigen::Vector2d(0.5 * i, 0), SO2(0.0)));
    const double range = (beacon - Eigen::Vector2d(0.5 * i, 0)).norm();
    const auto factor = std::make_shared<Range<SE2, Eigen::Vector2d>>(pose, Key('l', 0), range,
                                                                      Noise::isotropic(1, 0.05));
    bank.add({factor, factor}, options);
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
  bank.add({aside, aside}, options);
  bank.add({aside, aside}, options);
  bank.refine([&](Key key) { return poses.data(key); }, options);
  ASSERT_TRUE(bank.decided(options));
  EXPECT_NEAR(bank.decided(options)->y(), 4, 0.1);
}

}  // namespace
}  // namespace hybrid
