// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/plugins/bearing_range_association.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

/// A robot that drives rounds among trees and cars which its sensor does not tell apart by name.
struct Rounds {
  double sigma_motion = 0.05, sigma_turn = 0.01, sigma_range = 0.05, sigma_yaw = 0.01;
  double reach = 8, yaw_of_sensor = 0, clutter = 0;
  bool classed = true;
  std::mt19937 random{1};
  std::vector<Eigen::Vector2d> landmarks;

  Rounds() {
    for (int i = 0; i < 12; ++i) {  // uneven, so that no turn of the map looks like another
      const double r = (i % 2 == 0 ? 13 : 7) + uniform(-1.5, 1.5);
      const double a = 0.5236 * i + uniform(-0.2, 0.2);
      landmarks.emplace_back(r * std::cos(a), r * std::sin(a));
    }
  }
  double gauss(double sigma) { return sigma * std::normal_distribution<double>()(random); }
  double uniform(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  }
  static CPose3D pose(int i) {
    const double a = 0.05 * i;
    return {10 * std::cos(a), 10 * std::sin(a), 0, a + M_PI_2, 0, 0};
  }

  Keyframe keyframe(int i) {
    Keyframe out;
    out.row = static_cast<std::size_t>(i);
    out.time = i;
    if (i > 0) {
      OdometryIncrement odometry;
      odometry.mean = pose(i) - pose(i - 1) +
                      CPose3D(gauss(sigma_motion), gauss(sigma_motion), 0, gauss(sigma_turn), 0, 0);
      odometry.is_planar = true;
      const double m = sigma_motion * sigma_motion, t = sigma_turn * sigma_turn;
      odometry.covariance.diagonal() << m, m, 1e-4, 1e-4, 1e-4, t;
      out.odometry = odometry;
    }
    DetectionFrame frame;
    frame.is_3d = false;
    const CPose3D T_robot_sensor(0, 0, 0, yaw_of_sensor, 0, 0);
    frame.T_robot_sensor = to_isometry(T_robot_sensor);
    frame.max_range = reach;
    frame.fov_yaw = 2 * M_PI;
    if (classed) frame.class_names = {"tree", "car"};
    for (std::size_t id = 0; id < landmarks.size(); ++id) {
      Detection d;
      (pose(i) + T_robot_sensor)
          .sphericalCoordinates({landmarks[id].x(), landmarks[id].y(), 0}, d.range, d.yaw, d.pitch);
      if (d.range > reach) continue;
      d.true_id = static_cast<std::int64_t>(id);
      add(d, id % 2 == 0, frame);
    }
    for (double c = clutter; c > 0; --c) {
      if (uniform(0, 1) > c) continue;
      Detection d;
      d.range = uniform(1, reach);
      d.yaw = uniform(-M_PI, M_PI);
      add(d, uniform(0, 1) < 0.5, frame);
    }
    out.detections = {frame};
    return out;
  }

  void add(Detection d, bool tree, DetectionFrame& frame) {
    d.range += gauss(sigma_range);
    d.yaw = std::remainder(d.yaw + gauss(sigma_yaw), 2 * M_PI);
    d.pitch = 0;
    if (uniform(0, 1) > 0.85) tree = !tree;
    if (classed) d.class_probabilities = {tree ? 0.85 : 0.15, tree ? 0.15 : 0.85};
    d.covariance.diagonal() << sigma_range * sigma_range, sigma_yaw * sigma_yaw, 0;
    frame.detections.push_back(d);
  }
};

Mapper make_mapper(IniFile& ini) {
  return {read_motion_options(ini),
          {make_plugin("BearingRangeAssociation", ini)},
          make_backend(ini.section("solver")),
          false};
}

/// Share of the sightings of true landmarks that went to the landmark most of their kind went to,
/// and which no other true landmark has.
double accuracy(const std::vector<AssociationDecision>& decisions) {
  std::map<std::int64_t, std::map<std::int64_t, int>> votes;
  int all = 0, right = 0;
  for (const AssociationDecision& d : decisions) {
    if (!d.true_id) continue;
    ++all;
    if (d.estimated_id) ++votes[*d.true_id][*d.estimated_id];
  }
  std::set<std::int64_t> taken;
  for (const auto& [id, counts] : votes) {
    std::pair<int, std::int64_t> best{0, -1};
    for (const auto& [estimate, n] : counts) best = std::max(best, {n, estimate});
    if (taken.insert(best.second).second) right += best.first;
  }
  return static_cast<double>(right) / all;
}

/// Every true landmark has one of the map near it, and the map has at most `most`.
void expect_all_found(const MapResult& result, const Rounds& world, double radius,
                      std::size_t most) {
  EXPECT_LE(result.landmarks.size(), most);
  const CPose3D origin = Rounds::pose(0);
  std::set<std::size_t> found;
  for (const LandmarkEstimate& landmark : result.landmarks) {
    const auto p = origin.composePoint({landmark.position.x(), landmark.position.y(), 0});
    for (std::size_t id = 0; id < world.landmarks.size(); ++id) {
      if ((world.landmarks[id] - Eigen::Vector2d(p.x, p.y)).norm() > radius) continue;
      found.insert(id);
      if (world.classed) {
        EXPECT_EQ(landmark.class_index, static_cast<int>(id % 2));
      }
    }
  }
  EXPECT_EQ(found.size(), world.landmarks.size());
}

TEST(Association, FindsLandmarksClassesAndSightings) {
  IniFile ini("", "test.ini");
  Rounds world;
  Mapper mapper = make_mapper(ini);
  for (int i = 0; i < 300; ++i) mapper.add(world.keyframe(i));
  mapper.finish();
  expect_all_found(mapper.result(), world, 0.3, 13);
  EXPECT_GT(accuracy(mapper.decisions()), 0.99);
}

// The cut at half a turn lies straight ahead: each landmark passes it.
TEST(Association, AnglesNearHalfATurnAreNothingSpecial) {
  for (const char* method : {"hypotheses", "nearest", "jcbb"}) {
    IniFile ini(std::string("[BearingRangeAssociation]\nmethod = ") + method, "test.ini");
    Rounds world;
    world.yaw_of_sensor = M_PI;
    Mapper mapper = make_mapper(ini);
    for (int i = 0; i < 200; ++i) mapper.add(world.keyframe(i));
    mapper.finish();
    EXPECT_LE(mapper.result().landmarks.size(), 14U) << method;
    EXPECT_GT(accuracy(mapper.decisions()), 0.93) << method;
  }
}

TEST(Association, MostClutterIsNoLandmark) {
  IniFile ini("[BearingRangeAssociation]\nconfirm = 5", "test.ini");
  Rounds world;
  world.clutter = 1.0;
  Mapper mapper = make_mapper(ini);
  for (int i = 0; i < 200; ++i) mapper.add(world.keyframe(i));
  mapper.finish();
  expect_all_found(mapper.result(), world, 0.5, 20);
  int rejected = 0, spurious = 0;
  for (const AssociationDecision& d : mapper.decisions()) {
    if (d.true_id) continue;
    ++spurious;
    rejected += d.estimated_id ? 0 : 1;
  }
  EXPECT_GT(rejected, 0.5 * spurious);
}

// One round without seeing anything twice drifts by metres: by little enough for landmarks to be
// made one pair by pair, or by so much that only their arrangement tells in some of the worlds.
void expect_loops_are_closed(double drift, double loops) {
  constexpr int kWorlds = 10;
  double worst = 0, reckoned = 0, closed = 0;  // sums over all worlds
  std::size_t landmarks = 0;
  for (unsigned seed = 1; seed <= kWorlds; ++seed) {
    IniFile ini("", "test.ini");
    Rounds world;
    world.sigma_turn = drift * 0.02;
    world.sigma_motion = drift * 0.1;
    world.reach = 5;
    world.random.seed(seed);
    Mapper mapper = make_mapper(ini);
    for (int i = 0; i < 300; ++i) mapper.add(world.keyframe(i));
    mapper.finish();
    const MapResult result = mapper.result();
    double off = 0, reckoned_off = 0;
    for (int i = 0; i < 300; ++i) {
      const CPose3D truth = Rounds::pose(i) - Rounds::pose(0);
      off = std::max(off, (result.trajectory[i].pose - truth).norm());
      reckoned_off = std::max(reckoned_off, (result.dead_reckoning[i].pose - truth).norm());
    }
    worst += off;
    reckoned += reckoned_off;
    landmarks += result.landmarks.size();
    const auto& statistics = mapper.statistics();
    closed += statistics.count("loops_closed") ? statistics.at("loops_closed") : 0;
  }
  EXPECT_GE(closed, loops) << drift;
  EXPECT_LT(worst, 0.3 * reckoned) << drift;
  EXPECT_LE(landmarks, 15U * kWorlds) << drift;
}

TEST(Association, LoopsAfterLargeDriftAreClosed) {
  expect_loops_are_closed(1, 0);
  expect_loops_are_closed(1.5, 1);
}

// What the book of landmarks says is what the graph holds.
TEST(Association, TheGraphHoldsEachSightingOnce) {
  IniFile ini("", "test.ini");
  Rounds world;
  world.clutter = 0.5;
  Mapper mapper = make_mapper(ini);
  for (int i = 0; i < 150; ++i) mapper.add(world.keyframe(i));
  mapper.finish();
  std::size_t sightings = 0;
  for (const LandmarkEstimate& landmark : mapper.result().landmarks) {
    sightings += static_cast<std::size_t>(landmark.sightings);
  }
  const HybridGraph& graph = mapper.backend().graph();
  EXPECT_EQ(graph.hybrid().size(), sightings);
  EXPECT_EQ(graph.continuous().size(), 150U);
  EXPECT_EQ(graph.discrete().size(), mapper.result().landmarks.size());
}

TEST(Association, WhatLandmarksStandForIsCountedOnlyWhereItIsAskedFor) {
  IniFile ini("[BearingRangeAssociation]\nmethod = jcbb\nextent = 0.2\n", "test.ini");
  Rounds world;
  Mapper mapper = make_mapper(ini);
  for (int i = 0; i < 60; ++i) mapper.add(world.keyframe(i));
  mapper.finish();
  const MapResult whole = mapper.result(), rest = mapper.result_without_sizes();
  ASSERT_EQ(rest.landmarks.size(), whole.landmarks.size());
  ASSERT_FALSE(rest.landmarks.empty());
  for (std::size_t l = 0; l < rest.landmarks.size(); ++l) {
    EXPECT_EQ(rest.landmarks[l].position, whole.landmarks[l].position);
    EXPECT_EQ(rest.landmarks[l].covariance, whole.landmarks[l].covariance);
    EXPECT_EQ(whole.landmarks[l].size.extent, 0.2);
    EXPECT_EQ(rest.landmarks[l].size.extent, 0);
  }
}

TEST(Association, KnownIdsOverride) {
  IniFile ini("", "test.ini");
  Rounds world;
  Mapper mapper = make_mapper(ini);
  for (int i = 0; i < 100; ++i) {
    Keyframe keyframe = world.keyframe(i);
    for (Detection& d : keyframe.detections.front().detections) d.id = d.true_id;
    mapper.add(keyframe);
  }
  mapper.finish();
  EXPECT_EQ(accuracy(mapper.decisions()), 1.0);
}

TEST(Association, WorksInTheOtherModes) {
  for (const char* mode : {"filter", "fixed_lag\nlag = 200", "batch\nsolve_every = 1"}) {
    IniFile ini(std::string("[solver]\nmode = ") + mode, "test.ini");
    Rounds world;
    Mapper mapper = make_mapper(ini);
    for (int i = 0; i < 60; ++i) mapper.add(world.keyframe(i));
    mapper.finish();
    EXPECT_GT(accuracy(mapper.decisions()), 0.95) << mode;
  }
}

TEST(Association, BatchWithoutAnEstimateOnTheWayIsAnError) {
  IniFile ini("[solver]\nmode = batch", "test.ini");
  Rounds world;
  Mapper mapper = make_mapper(ini);
  EXPECT_THROW(
      {
        for (int i = 0; i < 3; ++i) mapper.add(world.keyframe(i));
      },
      SettingsError);
}

TEST(Association, TheSameInputGivesTheSameMap) {
  std::vector<MapResult> results;
  for (int k = 0; k < 2; ++k) {
    IniFile ini("", "test.ini");
    Rounds world;
    world.clutter = 1;
    Mapper mapper = make_mapper(ini);
    for (int i = 0; i < 100; ++i) mapper.add(world.keyframe(i));
    mapper.finish();
    results.push_back(mapper.result());
  }
  ASSERT_EQ(results[0].landmarks.size(), results[1].landmarks.size());
  for (std::size_t l = 0; l < results[0].landmarks.size(); ++l) {
    EXPECT_EQ(results[0].landmarks[l].position, results[1].landmarks[l].position);
  }
}

TEST(Association, SuitsWhatNoOtherPluginIdentifies) {
  const auto suits = [](const DetectionCounts& with_range, const DetectionCounts& without_range) {
    LogContents log;
    log.with_range = with_range;
    log.without_range = without_range;
    return BearingRangeAssociation().suits(log);
  };
  EXPECT_FALSE(suits({}, {}));
  EXPECT_TRUE(suits({10, 0, 0}, {}));
  EXPECT_FALSE(suits({10, 10, 0}, {}));
  EXPECT_TRUE(suits({}, {10, 0, 0}));
  EXPECT_FALSE(suits({}, {10, 10, 0}));
  EXPECT_TRUE(suits({10, 0, 0}, {10, 0, 0}));
  EXPECT_FALSE(suits({10, 10, 0}, {10, 0, 0})) << "two plugins would map the ranges";
}

}  // namespace
}  // namespace hybrid
