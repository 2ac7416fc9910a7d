// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/landmark_mapper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <type_traits>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/factors/sensor_view.h"
#include "libhybrid/geometry/isometry.h"

namespace hybrid {
namespace {

/// A robot on a curve among points, in the plane or in space.
template <class Pose>
struct Curve {
  static constexpr bool kIs3d = std::is_same_v<Pose, SE3>;
  static constexpr int kDim = Pose::kDim;
  using Point = typename Pose::Point;

  std::mt19937 random{4};
  std::vector<Point> points;
  Pose T_robot_sensor;
  std::vector<Pose> truth{Pose()};

  Curve() {
    for (int k = 0; k < 6; ++k) {
      Point p = Point::Zero();
      p[0] = 2.2 * k;
      p[1] = k % 2 == 0 ? 3 : -4;
      if (kIs3d) p[2] = 0.5 * (k % 3) - 0.5;
      points.push_back(p);
    }
    T_robot_sensor.store(storage);
    storage[0] = 0.3;
    T_robot_sensor = Pose::load(storage);
  }
  /// From a place to the nearest point [m].
  double distance(const Eigen::Vector3d& place) const {
    double nearest = 100;
    for (const auto& p : points) nearest = std::min(nearest, (place - padded_point(p)).norm());
    return nearest;
  }
  double noisy(double sigma) { return sigma * std::normal_distribution<double>()(random); }

  DetectionFrame look(bool with_ids = false) {
    DetectionFrame out;
    out.is_3d = kIs3d;
    out.T_robot_sensor = to_isometry(T_robot_sensor);
    out.max_range = 8;
    out.fov_yaw = 2 * M_PI;
    out.fov_pitch = kIs3d ? M_PI : 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const auto z =
          SensorView<Pose>(T_robot_sensor).polar(truth.back(), points[k], nullptr, nullptr);
      if (z[0] > out.max_range) continue;
      Detection d;
      d.range = z[0] + noisy(0.03);
      d.yaw = z[1] + noisy(0.01);
      d.covariance.diagonal() << 9e-4, 1e-4, 0;
      if constexpr (kIs3d) {
        d.pitch = z[2] + noisy(0.01);
        d.covariance(2, 2) = 1e-4;
      }
      d.true_id = static_cast<std::int64_t>(k);
      if (with_ids) d.id = d.true_id;
      out.detections.push_back(d);
    }
    return out;
  }
  /// The next motion as measured.
  Pose step() {
    typename Pose::Tangent v = Pose::Tangent::Zero();
    v[0] = 0.4;
    v[kDim - 1] = 0.02;
    truth.push_back(truth.back() * Pose::exp(v));
    for (int i = 0; i < kDim; ++i) v[i] += noisy(i < Point::RowsAtCompileTime ? 0.02 : 0.005);
    return Pose::exp(v);
  }
  static Noise noise(double scale = 1) {
    Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(kDim, 0.005 * scale);
    sigmas.head(Point::RowsAtCompileTime).setConstant(0.02 * scale);
    return Noise::diagonal(sigmas);
  }

 private:
  double storage[Pose::kSize] = {};
};

template <class Pose>
class LandmarkMapping : public ::testing::Test {};
using Poses = ::testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(LandmarkMapping, Poses);

/// The landmarks after a drive on which id 99 is seen besides, step by step at a range [m].
template <class Pose>
std::size_t landmarks_with_id_seen(const std::map<int, double>& range_at, Curve<Pose>& drive) {
  LandmarkMapper<Pose> mapper;
  for (int i = 0; i < 45; ++i) {
    const Pose motion = i == 0 ? Pose() : drive.step();
    DetectionFrame seen = drive.look(true);
    const auto at = range_at.find(i);
    if (at != range_at.end()) {
      Detection named;
      named.id = 99;
      named.range = at->second;
      named.covariance.diagonal() << 9e-4, 9e-4, Curve<Pose>::kIs3d ? 9e-4 : 0;
      seen.detections.push_back(named);
    }
    EXPECT_TRUE(mapper.add(motion, Curve<Pose>::noise(i == 0 ? 0.01 : 1), {seen})) << i;
  }
  mapper.finish();
  return mapper.landmarks().size();
}

/// A landmark seen once and then missed is taken for clutter; its id may well be seen again.
TYPED_TEST(LandmarkMapping, AnIdThatWasTakenForClutterIsMappedWhenItIsSeenAgain) {
  Curve<TypeParam> drive;
  std::map<int, double> range_at = {{3, 3}};
  for (int i = 38; i < 45; ++i) range_at[i] = 3 - 0.4 * (i - 38);
  EXPECT_EQ(landmarks_with_id_seen(range_at, drive), drive.points.size() + 1);
}

/// What the sensor has named twice is there, however often it was missed afterwards.
TYPED_TEST(LandmarkMapping, AnIdThatWasSeenTwiceStays) {
  Curve<TypeParam> drive;
  EXPECT_EQ(landmarks_with_id_seen({{3, 3}, {4, 2.6}}, drive), drive.points.size() + 1);
}

/// A sensor misreads an id now and then: what it names then is somewhere else.
TYPED_TEST(LandmarkMapping, IdsThatTheSensorMisreadAreClutter) {
  using Pose = TypeParam;
  Curve<Pose> drive;
  LandmarkMapper<Pose> mapper;
  std::size_t misread = 0;
  for (int i = 0; i < 45; ++i) {
    const Pose motion = i == 0 ? Pose() : drive.step();
    DetectionFrame seen = drive.look(true);
    if (i >= 10 && i % 5 == 0 && seen.detections.size() > 1) {
      std::swap(seen.detections[0].id, seen.detections[1].id);
      misread += 2;
    }
    EXPECT_TRUE(mapper.add(motion, Curve<Pose>::noise(i == 0 ? 0.01 : 1), {seen})) << i;
  }
  mapper.finish();
  ASSERT_GT(misread, 8U);
  ASSERT_EQ(mapper.landmarks().size(), drive.points.size());
  for (const auto& [id, landmark] : mapper.landmarks()) {
    EXPECT_LT(drive.distance(point_at(mapper.smoother().values(), landmark.position)), 0.25);
  }
  std::size_t clutter = 0;
  for (const AssociationDecision& d : mapper.decisions()) clutter += d.estimated_id ? 0 : 1;
  EXPECT_EQ(clutter, misread);
}

TYPED_TEST(LandmarkMapping, EveryPointIsALandmarkAndEverySightingGoesToItsOwn) {
  using Pose = TypeParam;
  Curve<Pose> drive;
  LandmarkMapper<Pose> mapper;
  EXPECT_TRUE(mapper.add(Pose(), Curve<Pose>::noise(0.01), {drive.look()}));
  for (int i = 1; i < 45; ++i) {
    const Pose motion = drive.step();
    EXPECT_TRUE(mapper.add(motion, Curve<Pose>::noise(), {drive.look()}));
  }
  mapper.finish();
  ASSERT_EQ(mapper.landmarks().size(), drive.points.size());
  std::size_t sightings = 0;
  for (const auto& [id, landmark] : mapper.landmarks()) {
    EXPECT_LT(drive.distance(point_at(mapper.smoother().values(), landmark.position)), 0.25);
    sightings += static_cast<std::size_t>(landmark.sightings);
  }
  // The graph holds the motions and each sighting once.
  const HybridGraph& graph = mapper.smoother().graph();
  EXPECT_EQ(graph.continuous().size() + graph.hybrid().size(), mapper.keyframes() + sightings);
  std::map<std::int64_t, std::int64_t> landmark_of;
  for (const AssociationDecision& d : mapper.decisions()) {
    ASSERT_TRUE(d.true_id && d.estimated_id);
    EXPECT_EQ(landmark_of.emplace(*d.true_id, *d.estimated_id).first->second, *d.estimated_id);
  }
}

TEST(LandmarkMapper, KnownIdsAreTaken) {
  Curve<SE2> drive;
  drive.points = {{5, 1}, {5, 1.02}};  // nearer than can be told
  LandmarkMapper<SE2> mapper;
  mapper.add(SE2(), Curve<SE2>::noise(0.01), {drive.look(true)});
  for (int i = 1; i < 10; ++i) {
    const SE2 motion = drive.step();
    mapper.add(motion, Curve<SE2>::noise(), {drive.look(true)});
  }
  mapper.finish();
  EXPECT_EQ(mapper.landmarks().size(), 2U);
  for (const auto& [id, landmark] : mapper.landmarks()) EXPECT_EQ(landmark.sightings, 10);
}

TEST(LandmarkMapper, AKeyframeThatMakesNoSenseAddsNothing) {
  Curve<SE2> drive, same;
  LandmarkMapper<SE2> mapper, other;
  mapper.add(SE2(), Curve<SE2>::noise(0.01), {drive.look()});
  other.add(SE2(), Curve<SE2>::noise(0.01), {same.look()});
  for (int i = 1; i < 20; ++i) {
    const SE2 motion = drive.step();
    const DetectionFrame seen = drive.look();
    if (i == 10) {
      const double objective = mapper.smoother().objective();
      const std::size_t landmarks = mapper.landmarks().size();
      DetectionFrame wrong = seen;  // the first of its detections can be used
      wrong.class_names = {"dog"};
      for (Detection& d : wrong.detections) d.class_probabilities = {1.0};
      ClassOptions options;
      options.names = {"tree", "car"};
      LandmarkMapper<SE2> with_classes(LandmarkAssociation({}, ClassModel(options)));
      with_classes.add(SE2(), Curve<SE2>::noise(0.01), {seen});
      EXPECT_THROW(with_classes.add(motion, Curve<SE2>::noise(), {seen, wrong}), Error);
      EXPECT_EQ(with_classes.keyframes(), 1U);
      EXPECT_EQ(with_classes.smoother().graph().continuous().size(), 1 + seen.detections.size());
      const SE2 bad(std::nan(""), 0, 0);
      EXPECT_THROW(mapper.add(bad, Curve<SE2>::noise(), {seen}), Error);
      EXPECT_EQ(mapper.keyframes(), 10U);
      EXPECT_EQ(mapper.smoother().objective(), objective);
      EXPECT_EQ(mapper.landmarks().size(), landmarks);
    }
    mapper.add(motion, Curve<SE2>::noise(), {seen});
    same.step();
    other.add(motion, Curve<SE2>::noise(), {same.look()});
  }
  mapper.finish();
  other.finish();
  EXPECT_EQ(mapper.smoother().objective(), other.smoother().objective());
}

TEST(LandmarkMapper, ACopyGoesItsOwnWay) {
  Curve<SE2> drive;
  LandmarkMapper<SE2> mapper;
  mapper.add(SE2(), Curve<SE2>::noise(0.01), {drive.look()});
  for (int i = 1; i < 8; ++i) {
    const SE2 motion = drive.step();
    mapper.add(motion, Curve<SE2>::noise(), {drive.look()});
  }
  LandmarkMapper<SE2> copy = mapper;
  const double objective = mapper.smoother().objective();
  const SE2 motion = drive.step();
  const DetectionFrame seen = drive.look();
  copy.add(motion, Curve<SE2>::noise(), {seen});
  EXPECT_EQ(mapper.keyframes(), 8U);
  EXPECT_EQ(mapper.smoother().objective(), objective);
  mapper.add(motion, Curve<SE2>::noise(), {seen});
  EXPECT_EQ(mapper.smoother().objective(), copy.smoother().objective());
}

TEST(LandmarkMapper, DetectionsThatDoNotFitTheMapAreCountedNotUsed) {
  Curve<SE3> drive;
  LandmarkMapper<SE2> mapper;
  EXPECT_TRUE(mapper.add(SE2(), Curve<SE2>::noise(), {drive.look()}));
  EXPECT_EQ(mapper.landmarks().size(), 0U);
  EXPECT_EQ(mapper.smoother().graph().size(), 1U);
}

}  // namespace
}  // namespace hybrid
