// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_place.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>
#include <vector>

#include "libhybrid/clouds/cloud_join.h"
#include "libhybrid/geometry/isometry.h"
#include "tests/support/cloud_worlds.h"

namespace hybrid {
namespace {

using testing::cloud_at;
using testing::CloudWorld;
using testing::long_hall;
using testing::way_along_hall;

const Eigen::Vector3f kSensorHere = Eigen::Vector3f::Zero();

CloudMapperOptions short_maps() {
  CloudMapperOptions options;
  options.tracker.map_length = 2;  // of 5 m, so that there are several local maps
  return options;
}

/// Where odometry says that the second of two poses is, seen from the first.
UncertainMotion3 by_odometry(const SE3& a, const SE3& b) {
  const SE3 drift(Eigen::Vector3d(0.01, 0, 0), SO3::exp(Eigen::Vector3d(0, 0, 0.004)));
  Eigen::Matrix<double, 6, 1> sigmas;
  sigmas << 0.04, 0.04, 0.04, 0.02, 0.02, 0.02;
  return {a.between(b) * drift, sigmas.cwiseAbs2().asDiagonal()};
}

void drive(const CloudWorld& world, const std::vector<SE3>& way, unsigned seed,
           CloudMapper& mapper) {
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < way.size(); ++i) {
    std::optional<UncertainMotion3> odometry;
    if (i > 0) odometry = by_odometry(way[i - 1], way[i]);
    mapper.add(cloud_at(world, way[i], random), kSensorHere, odometry);
  }
  mapper.finish();
}

/// What a drive has seen, where its path is; `T` moves all of it.
std::vector<StoredCloud> stored_by(const CloudMapper& mapper, const SE3& T = SE3()) {
  std::vector<StoredCloud> out;
  for (const LocalCloud& map : mapper.tracker().local_maps()) {
    const bool grows = &map == &mapper.tracker().local_maps().back();
    out.push_back({{T * mapper.pose(map.anchor), 1e-4 * Matrix6::Identity()},
                   grows ? mapper.tracker().surfaces()->points() : map.points,
                   0.03 * mapper.tracker().reach()});
  }
  return out;
}

std::vector<SE3> way_there() {
  return way_along_hall(0.5, -20, 20);
}

/// A later drive: it begins elsewhere, and goes the other way.
std::vector<SE3> way_back() {
  return way_along_hall(0.5, 12, -12);
}

/// The first drive in the hall, as a map.
std::vector<StoredCloud> hall_map(const SE3& T = SE3()) {
  CloudMapper mapper(short_maps());
  drive(long_hall(), way_there(), 1, mapper);
  return stored_by(mapper, T);
}

std::optional<UncertainMotion3> found_on(const CloudWorld& world, const std::vector<SE3>& way,
                                         const std::vector<StoredCloud>& map) {
  CloudPlaceSearch search(map);
  CloudMapper mapper(short_maps());
  std::mt19937 random(2);
  for (std::size_t i = 0; i < way.size(); ++i) {
    std::optional<UncertainMotion3> odometry;
    if (i > 0) odometry = by_odometry(way[i - 1], way[i]);
    mapper.add(cloud_at(world, way[i], random), kSensorHere, odometry);
    if (const auto found = search.look(mapper)) return found;
  }
  return std::nullopt;
}

TEST(CloudPlace, ADriveIsFoundInTheMapOfAnother) {
  const std::vector<SE3> way = way_back();
  const auto found = found_on(long_hall(), way, hall_map());
  ASSERT_TRUE(found);
  const SE3 truth = way_there()[0].between(way[0]);
  const SE3 off = truth.between(found->motion);
  EXPECT_LT(off.translation().norm(), 0.3);
  EXPECT_LT(off.rotation().log().norm(), 0.03);
  const SE3::Tangent e = off.log();
  EXPECT_LT(e.dot(found->covariance.inverse() * e), 40);
}

TEST(CloudPlace, ADriveElsewhereIsNotFound) {
  EXPECT_FALSE(found_on(long_hall(8), way_back(), hall_map()));
  EXPECT_FALSE(found_on(long_hall(), way_back(), {}));
}

TEST(CloudPlace, OfTwoEqualStoreysNoneIsTaken) {
  std::vector<StoredCloud> map = hall_map();
  for (const StoredCloud& above : hall_map(SE3({0, 0, 6}, SO3()))) map.push_back(above);
  EXPECT_FALSE(found_on(long_hall(), way_back(), map));
}

TEST(CloudPlace, AKnownMapKeepsALaterDriveInPlace) {
  const std::vector<SE3> way = way_back();
  const SE3 origin = way_there()[0];
  const SE3 start = origin.between(way[0]) * SE3({0.1, -0.1, 0.05}, SO3());
  CloudMapper mapper(short_maps());
  Eigen::Matrix<double, 6, 1> sigmas;
  sigmas << 0.2, 0.2, 0.2, 0.03, 0.03, 0.03;
  mapper.adopt(hall_map(), {start, sigmas.cwiseAbs2().asDiagonal()});
  drive(long_hall(), way, 3, mapper);
  std::size_t accepted = 0;
  for (std::size_t k = 0; k < mapper.closures().size(); ++k) {
    const bool is_known = mapper.closures()[k].is_known;
    if (is_known && mapper.status(k) == ClosureStatus::kAccepted) ++accepted;
  }
  EXPECT_GT(accepted, 3U);
  for (std::size_t i = 0; i < way.size(); ++i) {
    const SE3 off = origin.between(way[i]).between(mapper.pose(i));
    EXPECT_LT(off.translation().norm(), 0.1) << i;
  }
}

/// A map in space of clouds alone.
MapRecord record_of(const std::vector<StoredCloud>& stored, int session) {
  MapRecord map;
  map.is_3d = true;
  map.prior.dim = 3;
  MapSession made;
  made.id = 1;
  made.complete = true;
  made.inputs = {{"log", std::to_string(session)}};
  map.sessions.push_back(made);
  for (const StoredCloud& cloud : stored) {
    MapLocalCloud local{1, cloud.T_map_anchor, cloud.spacing, {}};
    for (const CloudPoint& p : cloud.points) local.points.push_back({p.position, p.normal});
    map.local_clouds.push_back(local);
  }
  return map;
}

TEST(CloudPlace, TwoMapsAreJoinedByTheCloudsOfBoth) {
  const std::vector<SE3> way = way_back();
  CloudMapper second(short_maps());
  drive(long_hall(), way, 5, second);
  const MapRecord a = record_of(hall_map(), 1), b = record_of(stored_by(second), 2);
  std::string why;
  const auto joined = join_maps_by_clouds(a, b, 1e4, why);
  ASSERT_TRUE(joined) << why;
  EXPECT_GE(joined->scan_matches, 3U);
  const SE3 truth = way_there()[0].between(way[0]);
  const SE3 off = truth.between(to_se3(joined->T_first_second));
  EXPECT_LT(off.translation().norm(), 0.1);
  EXPECT_EQ(joined->map.local_clouds.size(), a.local_clouds.size() + b.local_clouds.size());
  EXPECT_EQ(joined->map.local_clouds.back().session, 2);

  MapRecord empty = b;
  empty.local_clouds.clear();
  EXPECT_FALSE(join_maps_by_clouds(a, empty, 1e4, why));
  EXPECT_NE(why, "");
}

}  // namespace
}  // namespace hybrid
