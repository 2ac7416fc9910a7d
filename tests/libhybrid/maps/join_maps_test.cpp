// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/join_maps.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "libhybrid/core/error.h"
#include "libhybrid/geometry/isometry.h"
#include "tests/libhybrid/maps/stored_maps.h"

namespace hybrid {
namespace {

/// Two maps that share the landmarks 30 to 59 of 90, each in a frame of its own.
struct TwoMaps {
  std::vector<Eigen::Vector3d> places;
  MapRecord a, b;
  Eigen::Isometry3d T_b_world = motion(20, -7, 2.5);

  explicit TwoMaps(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    places = scattered(90, 45, false, random);
    std::sort(places.begin(), places.end(),
              [](const auto& p, const auto& q) { return p.x() < q.x(); });
    a = stored_map({places.begin(), places.begin() + 60}, motion(0, 0, 0), false, 0.05, 0.01,
                   random);
    b = stored_map({places.begin() + 30, places.end()}, T_b_world, false, 0.05, 0.01, random);
  }
};

TEST(JoinMaps, MakesCommonLandmarksOne) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const TwoMaps maps(seed);
    const auto joined = join_maps(maps.a, maps.b, 1e4);
    ASSERT_TRUE(joined) << seed;
    EXPECT_EQ(joined->map.landmarks.size(), 90u) << seed;
    EXPECT_EQ(joined->common, 30u) << seed;
    const Eigen::Isometry3d off = maps.T_b_world * joined->T_first_second;
    EXPECT_LT(off.translation().norm(), 0.6) << seed;
    // What all landmarks are off by, as their joint covariance has it.
    Eigen::VectorXd error(180);
    for (std::size_t i = 0; i < 90; ++i) {
      const auto at = 2 * static_cast<Eigen::Index>(i);
      error.segment<2>(at) = (joined->map.landmarks[i].position - maps.places[i]).head<2>();
    }
    const double nees =
        error.dot(Eigen::LLT<Eigen::MatrixXd>(joint_covariance(joined->map)).solve(error)) / 180;
    EXPECT_NEAR(nees, 1.0, 4 * std::sqrt(2.0 / 180)) << seed;
  }
}

TEST(JoinMaps, KeepsSessionsApart) {
  const TwoMaps maps(1);
  const auto joined = join_maps(maps.a, maps.b, 1e4);
  ASSERT_TRUE(joined);
  ASSERT_EQ(joined->map.sessions.size(), 2u);
  EXPECT_EQ(joined->map.sessions[1].id, 2);
  EXPECT_EQ(joined->map.landmarks.back().session, 2);
}

/// A local map of a robot that was exactly there, by what the map knows of it.
MapLocalMap local_map_at(const SE2& pose, double sigma) {
  MapLocalMap local;
  local.session = 1;
  local.pose << pose.x(), pose.y(), pose.angle();
  local.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  return local;
}

TEST(JoinMaps, LocalMapsAreAsUncertainAsTheMotionBetweenTheMaps) {
  double sum = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6, 7, 8}) {
    std::mt19937_64 random(seed);
    const auto places = scattered(24, 20, false, random);
    const Eigen::Isometry3d T_b_world = motion(20, -7, 2.5);
    const MapRecord a = stored_map({places.begin(), places.begin() + 16}, motion(0, 0, 0), false,
                                   0.05, 0.01, random);
    MapRecord b =
        stored_map({places.begin() + 8, places.end()}, T_b_world, false, 0.05, 0.01, random);
    const SE2 in_world(60, 10, 1);  // far from what both maps have
    b.local_maps = {local_map_at(to_se2(T_b_world) * in_world, 1e-3)};
    const auto joined = join_maps(a, b, 1e4);
    ASSERT_TRUE(joined) << seed;
    ASSERT_EQ(joined->map.local_maps.size(), 1u);
    const MapLocalMap& local = joined->map.local_maps[0];
    const SE2 pose(local.pose.x(), local.pose.y(), local.pose.z());
    const Eigen::Vector3d off = pose.between(in_world).log();
    sum += off.dot(local.covariance.llt().solve(off)) / 3;
  }
  EXPECT_NEAR(sum / 8, 1, 4 * std::sqrt(2.0 / 24));
}

TEST(JoinMaps, MergesNothingWithoutACommonPlace) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const TwoMaps maps(seed), others(seed + 100);
    EXPECT_FALSE(join_maps(maps.a, others.b, 1e4)) << seed;
  }
}

TEST(JoinMaps, RefusesMapsOfTwoKinds) {
  TwoMaps maps(1);
  maps.b.class_names = {"tree", "car"};
  EXPECT_THROW(join_maps(maps.a, maps.b, 1e4), Error);
}

TEST(JoinMaps, RefusesMapsThatHaveALogInCommon) {
  TwoMaps maps(1);
  maps.a.sessions[0].logs = {"monday", ""};
  maps.b.sessions[0].logs = {"tuesday", ""};  // what came through a pipe is not known
  EXPECT_TRUE(join_maps(maps.a, maps.b, 1e4));
  maps.b.sessions[0].logs = {"tuesday", "monday"};
  EXPECT_THROW(join_maps(maps.a, maps.b, 1e4), Error);
}

TEST(JoinMaps, ThePriorOfAClassCountsOnce) {
  TwoMaps maps(1);
  for (MapRecord* map : {&maps.a, &maps.b}) {
    map->class_names = {"tree", "car"};
    map->sessions[0].class_prior = {0.9, 0.1};
    for (MapLandmark& l : map->landmarks) l.class_probabilities = {0.9, 0.1};
  }
  // A detection that is nine times as likely for a car, in each map.
  maps.a.landmarks[40].class_probabilities = maps.b.landmarks[10].class_probabilities = {0.5, 0.5};
  const auto joined = join_maps(maps.a, maps.b, 1e4);
  ASSERT_TRUE(joined);
  ASSERT_EQ(joined->common, 30u);
  EXPECT_NEAR(joined->map.landmarks[35].class_probabilities[0], 0.9, 1e-9);
  EXPECT_NEAR(joined->map.landmarks[40].class_probabilities[0], 0.1, 1e-9);
}

TEST(JoinMaps, NothingIsSaidOfTheFrameOfTheFirst) {
  for (const double common : {0.1, 1.0, 10.0}) {
    std::mt19937_64 random(2);
    const auto places = scattered(40, 40, false, random);
    MapRecord a = stored_map(places, motion(0, 0, 0), false, 0.003, 0.0, random);
    const MapRecord b = stored_map(places, motion(5, 2, 1), false, 0.003, 0.0, random);
    Eigen::MatrixXd C = joint_covariance(a);
    for (int i = 0; i < 40; ++i) {
      for (int k = 0; k < 40; ++k) {
        C.block(2 * i, 2 * k, 2, 2).diagonal().array() += common * common;
      }
    }
    a.prior = sparsify(C, 2, 1e-6);
    const auto joined = join_maps(a, b, 1e4);
    ASSERT_TRUE(joined) << common;
    const double sigma = std::sqrt(joint_covariance(joined->map)(0, 0));
    EXPECT_NEAR(sigma, std::sqrt(C(0, 0)), 0.01 * sigma) << common;
  }
}

/// Five maps of parts of one place whose ids are those of the world, in frames of their own; the
/// fourth has one of its landmarks 6 m off.
std::vector<MapRecord> five_maps(std::uint64_t seed, std::int64_t misread) {
  std::mt19937_64 random(seed);
  const auto places = scattered(15, 15, false, random);
  std::vector<MapRecord> out;
  for (int robot = 0; robot < 5; ++robot) {
    MapRecord map = stored_map(places, motion(3 * robot, -robot, robot), false, 0.03, 0.01, random);
    map.identified = true;
    for (MapLandmark& l : map.landmarks) l.sightings = 20;
    MapLandmark& wrong = map.landmarks[static_cast<std::size_t>(misread)];
    if (robot == 3) {
      wrong.position.head<2>() += Eigen::Vector2d(3.6, -4.8);
      wrong.sightings = 1;
    }
    out.push_back(std::move(map));
  }
  return out;
}

TEST(JoinMaps, OneLandmarkThatContradictsIsLeftOutInEveryOrder) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const std::vector<MapRecord> maps = five_maps(seed, 9);
    std::vector<std::size_t> order{0, 1, 2, 3, 4};
    for (int turn = 0; turn < 5; ++turn) {
      std::rotate(order.begin(), order.begin() + 1, order.end());
      MapRecord all = maps[order[0]];
      std::size_t contradictions = 0;
      for (std::size_t k = 1; k < 5; ++k) {
        const auto joined = join_maps(all, maps[order[k]], 1e4);
        ASSERT_TRUE(joined) << seed << " " << turn;
        for (const Contradiction& c : joined->contradictions) {
          EXPECT_EQ(c.id, 9);
          EXPECT_NEAR(c.distance, 6, 0.5);
        }
        contradictions += joined->contradictions.size();
        all = joined->map;
      }
      EXPECT_EQ(contradictions, 1u) << seed << " " << turn;
      ASSERT_EQ(all.landmarks.size(), 15u);
      EXPECT_EQ(all.landmarks[9].sightings, 80);
      EXPECT_EQ(all.landmarks[8].sightings, 100);
      // What each landmark is off from the place it has in a map that is right.
      const MapRecord& right = maps[order[0] == 3 ? order[1] : order[0]];
      const double d = (right.landmarks[9].position - right.landmarks[2].position).norm();
      EXPECT_NEAR((all.landmarks[9].position - all.landmarks[2].position).norm(), d, 0.3);
    }
  }
}

TEST(JoinMaps, ManyLandmarksTakeNoDenseMatrix) {
  // 2,400 landmarks along a street, 1,600 of them in each map.
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> across(0, 60);
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < 2400; ++i) places.emplace_back(2.0 * i, across(random), 0);
  const auto walk = [&](int from, int to, const Eigen::Isometry3d& T) {
    MapRecord map;
    map.identified = true;
    std::normal_distribution<double> normal(0, 0.05);
    for (int i = from; i < to; ++i) {
      MapLandmark l;
      l.id = i;
      l.position = T * places[static_cast<std::size_t>(i)];
      l.position.head<2>() += Eigen::Vector2d(normal(random), normal(random));
      l.existence = l.sightings = 5;
      SparseRow row;
      const int own = i - from;
      row.variables = {own};
      row.R = Eigen::Matrix2d::Identity() / 0.05;
      if (own > 0) {
        row.variables.push_back(own - 1);
        row.R.conservativeResize(2, 4);
        row.R.rightCols(2) = -0.5 * Eigen::Matrix2d::Identity() / 0.05;
      }
      map.prior.rows.push_back(row);
      map.landmarks.push_back(l);
    }
    map.sessions.resize(1);
    map.sessions[0].id = 1;
    return map;
  };
  const MapRecord a = walk(0, 1600, motion(0, 0, 0)), b = walk(800, 2400, motion(7, 1, 2));
  const auto joined = join_maps(a, b, 1e4);
  ASSERT_TRUE(joined);
  EXPECT_EQ(joined->map.landmarks.size(), 2400u);
  EXPECT_EQ(joined->common, 800u);
  std::size_t most = 0;
  for (const SparseRow& row : joined->map.prior.rows) most = std::max(most, row.variables.size());
  EXPECT_LE(most, 33u);
  const auto alone = joined->map.prior.covariances();
  for (const std::size_t i : {0, 700, 1200}) {
    EXPECT_NEAR(alone[i](0, 0), joined->map.landmarks[i].covariance(0, 0), 0.1 * alone[i](0, 0));
  }
  const MapRecord less = without_landmarks(joined->map, {3, 900});
  EXPECT_EQ(less.landmarks.size(), 2398u);
}

TEST(WithoutLandmarks, TheOthersStayAsTheyWere) {
  const TwoMaps maps(1);
  const MapRecord rest = without_landmarks(maps.a, {0, 7});
  ASSERT_EQ(rest.landmarks.size(), 58u);
  EXPECT_EQ(rest.landmarks[0].id, 1);
  const Eigen::MatrixXd before = joint_covariance(maps.a), after = joint_covariance(rest);
  EXPECT_NEAR(after(0, 0), before(2, 2), 0.05 * before(2, 2));
}

}  // namespace
}  // namespace hybrid
