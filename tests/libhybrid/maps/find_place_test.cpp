// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/find_place.h"

#include <gtest/gtest.h>

#include <numeric>

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "tests/libhybrid/maps/stored_maps.h"

namespace hybrid {
namespace {

constexpr double kSigma = 0.05;  // of what is seen here [m]
constexpr double kPlaceOdds = 1e4;

template <class Pose>
Pose pose_of(const Eigen::Isometry3d& T) {
  Values values;
  insert_pose(values, Key(), T, Pose::kDim == 6);
  return values.at<Pose>(Key());
}

/// What a robot at T_world_here sees of a map: those within a range [m], and some things more.
template <class Pose>
PlaceQuestion<Pose> question(const MapRecord& map, const std::vector<Eigen::Vector3d>& places,
                             const Eigen::Isometry3d& T_world_here, int others,
                             std::mt19937_64& random, double range = 12, double sigma = kSigma) {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  std::normal_distribution<double> normal(0, sigma);
  std::uniform_real_distribution<double> along(-range, range);
  PlaceQuestion<Pose> q;
  const auto see = [&](const Eigen::Vector3d& p) {
    typename Pose::Point seen = p.head<kDim>();
    for (double& v : seen) v += normal(random);
    q.here.points.push_back(seen);
    q.here.covariances.push_back(sigma * sigma * Constellation<Pose>::Matrix::Identity());
  };
  for (const Eigen::Vector3d& p : places) {
    if ((p - T_world_here.translation()).norm() < range) see(T_world_here.inverse() * p);
  }
  for (int i = 0; i < others; ++i) {
    see({along(random), along(random), kDim == 3 ? along(random) : 0.0});
  }
  std::vector<int> all(map.landmarks.size());
  std::iota(all.begin(), all.end(), 0);
  q.map = std::make_shared<PlaceMap<Pose>>(map, all);
  q.class_log_likelihood_ratio.setZero(static_cast<Eigen::Index>(q.here.points.size()),
                                       static_cast<Eigen::Index>(all.size()));
  q.class_log_likelihood_ratio_in_map = [](int, int) { return 0.0; };
  return q;
}

TEST(FindPlace, FindsARobotAnywhereInThePlane) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> along(8, 32), turn(-M_PI, M_PI);
  const auto places = scattered(60, 40, false, random);
  const MapRecord map = stored_map(places, motion(5, -3, 2), false, 0.05, 0.02, random);
  int found = 0;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Isometry3d here = motion(along(random), along(random), turn(random));
    const auto place = PlaceSearch(kPlaceOdds).find(question<SE2>(map, places, here, 2, random));
    if (!place) continue;
    ++found;
    const SE2 off = pose_of<SE2>(motion(5, -3, 2) * here).between(place->T_map_here);
    EXPECT_LT(off.translation().norm(), 1.0) << i;
    EXPECT_LT(std::abs(off.log()[2]), 0.1) << i;
  }
  EXPECT_GE(found, 15);
}

TEST(FindPlace, FindsARobotAnywhereInSpace) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> along(6, 14), turn(-M_PI, M_PI);
  const auto places = scattered(40, 20, true, random);
  const MapRecord map = stored_map(places, motion(5, -3, 2), true, 0.05, 0.01, random);
  int found = 0;
  for (int i = 0; i < 5; ++i) {
    Eigen::Isometry3d here = motion(along(random), along(random), turn(random));
    here.rotate(Eigen::AngleAxisd(turn(random), Eigen::Vector3d(1, 2, 3).normalized()));
    here.translation().z() = along(random);
    const auto place = PlaceSearch(kPlaceOdds).find(question<SE3>(map, places, here, 2, random));
    if (!place) continue;
    ++found;
    const SE3 off = pose_of<SE3>(motion(5, -3, 2) * here).between(place->T_map_here);
    EXPECT_LT(off.log().norm(), 0.5) << i;
  }
  EXPECT_GE(found, 4);
}

TEST(FindPlace, FindsNothingInAnotherMap) {
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> along(8, 32), turn(-M_PI, M_PI);
  const auto here = scattered(60, 40, false, random);
  for (int i = 0; i < 20; ++i) {
    const auto elsewhere = scattered(60, 40, false, random);
    const MapRecord map = stored_map(elsewhere, motion(0, 0, 0), false, 0.05, 0.02, random);
    const Eigen::Isometry3d T = motion(along(random), along(random), turn(random));
    EXPECT_FALSE(PlaceSearch(kPlaceOdds).find(question<SE2>(map, here, T, 0, random))) << i;
  }
}

TEST(FindPlace, DoesNotChooseBetweenTwoThatAreAlike) {
  std::mt19937_64 random(14);
  auto places = scattered(15, 12, false, random);
  const std::size_t n = places.size();
  for (std::size_t i = 0; i < n; ++i) places.push_back(places[i] + Eigen::Vector3d(60, 0, 0));
  const MapRecord map = stored_map(places, motion(0, 0, 0), false, 0.05, 0.001, random);
  const auto q = question<SE2>(map, places, motion(6, 6, 1), 0, random);
  EXPECT_FALSE(PlaceSearch(kPlaceOdds).find(q));
}

TEST(FindPlace, ClassesTellTwoThatAreAlikeApart) {
  std::mt19937_64 random(14);
  auto places = scattered(15, 12, false, random);
  const std::size_t n = places.size();
  for (std::size_t i = 0; i < n; ++i) places.push_back(places[i] + Eigen::Vector3d(60, 0, 0));
  const MapRecord map = stored_map(places, motion(0, 0, 0), false, 0.05, 0.001, random);
  auto q = question<SE2>(map, places, motion(6, 6, 1), 0, random);
  const std::vector<double> seen{0.9, 0.1}, one{0.9, 0.1}, other{0.1, 0.9}, prior{0.5, 0.5};
  for (Eigen::Index j = 0; j < q.class_log_likelihood_ratio.cols(); ++j) {
    const bool first = j < static_cast<Eigen::Index>(n);
    q.class_log_likelihood_ratio.col(j).setConstant(
        same_class_log_likelihood_ratio(seen, first ? one : other, prior));
  }
  const auto place = PlaceSearch(kPlaceOdds).find(q);
  ASSERT_TRUE(place);
  EXPECT_LT((place->T_map_here.translation() - Eigen::Vector2d(6, 6)).norm(), 0.5);
}

/// Cars parked on both sides of streets that cross, a place in three empty.
std::vector<Eigen::Vector3d> parked_cars(std::mt19937_64& random) {
  std::normal_distribution<double> off(0, 0.3);
  std::vector<Eigen::Vector3d> out;
  for (int street = -1; street <= 1; ++street) {
    for (int k = -14; k <= 14; ++k) {
      for (const double side : {-4.0, 4.0}) {
        const Eigen::Vector3d p(40 * street + side + off(random), 6 * k + off(random), 0);
        if (random() % 3 > 0) out.push_back(p);
        if (random() % 3 > 0) out.emplace_back(-p.y(), p.x(), 0);
      }
    }
  }
  return out;
}

/// Places where a robot looks that drives along a street.
std::vector<Eigen::Isometry3d> drive() {
  std::vector<Eigen::Isometry3d> out;
  for (double y = -40; y <= 40; y += 10) out.push_back(motion(40, y, M_PI / 2));
  return out;
}

TEST(FindPlace, RowsOfParkedCarsOfAnotherTownAreNoPlace) {
  constexpr double kCar = 0.4;  // of what is seen and of the map [m]
  for (const unsigned seed : {1, 3, 7}) {
    std::mt19937_64 random(seed);
    const auto town = parked_cars(random), other = parked_cars(random);
    const MapRecord map = stored_map(other, motion(0, 0, 0), false, kCar, 0.001, random);
    PlaceSearch search(kPlaceOdds);
    for (const Eigen::Isometry3d& T : drive()) {
      EXPECT_FALSE(search.find(question<SE2>(map, town, T, 0, random, 25, kCar))) << seed;
    }
  }
}

TEST(FindPlace, RowsOfParkedCarsOfTheSameTownAreFound) {
  constexpr double kCar = 0.4;
  int found = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937_64 random(seed);
    const auto town = parked_cars(random);
    const MapRecord map = stored_map(town, motion(0, 0, 0), false, kCar, 0.001, random);
    PlaceSearch search(kPlaceOdds);
    for (const Eigen::Isometry3d& T : drive()) {
      const auto place = search.find(question<SE2>(map, town, T, 0, random, 25, kCar));
      if (!place) continue;
      ++found;
      EXPECT_LT((place->T_map_here.translation() - T.translation().head<2>()).norm(), 1) << seed;
      break;
    }
  }
  EXPECT_GE(found, 7);
}

}  // namespace
}  // namespace hybrid
