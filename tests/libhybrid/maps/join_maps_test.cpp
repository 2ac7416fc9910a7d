// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/join_maps.h"

#include <gtest/gtest.h>

#include "libhybrid/core/error.h"
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
