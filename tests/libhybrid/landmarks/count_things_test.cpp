// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Landmarks that stand for several things.

#include "libhybrid/landmarks/count_things.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/landmarks/landmark_mapper.h"

namespace hybrid {
namespace {

constexpr double kDetectionSigma = 0.1;  // of where a detection puts its thing [m]

/// Groups of things a few centimetres apart, and a robot on a circle among them.
struct Groups {
  std::vector<Eigen::Vector2d> places;
  std::vector<int> counts;
  double detected = 0.9;
  std::mt19937 random;

  explicit Groups(unsigned seed) : random(seed) {
    for (int k = 0; k < 6; ++k) {
      const double angle = k * M_PI / 3, radius = k % 2 == 0 ? 7 : 2;
      places.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
      counts.push_back(1 + k % 3);
    }
  }
  double noisy(double sigma) { return sigma * std::normal_distribution<double>()(random); }
  SE2 truth(int i) const {
    const double angle = 0.1 * i;
    return {4.5 * std::cos(angle), 4.5 * std::sin(angle), angle + M_PI / 2};
  }

  DetectionFrame look(int i) {
    DetectionFrame out;
    out.is_3d = false;
    out.max_range = 20;
    out.fov_yaw = 2 * M_PI;
    for (std::size_t k = 0; k < places.size(); ++k) {
      for (int n = 0; n < counts[k]; ++n) {
        if (std::uniform_real_distribution<double>()(random) > detected) continue;
        const Eigen::Vector2d thing = places[k] + Eigen::Vector2d(0.06 * n, 0);
        const Eigen::Vector2d seen(truth(i).inverse() * thing);
        const Eigen::Vector2d z = to_polar(Eigen::Vector2d(
            seen + Eigen::Vector2d(noisy(kDetectionSigma), noisy(kDetectionSigma))));
        Detection d;
        d.range = z[0];
        d.yaw = z[1];
        d.covariance.diagonal() << kDetectionSigma * kDetectionSigma,
            kDetectionSigma * kDetectionSigma / (z[0] * z[0]), 0;
        out.detections.push_back(d);
      }
    }
    return out;
  }
};

/// A sensor beside that sees next to nothing.
DetectionFrame look_of_another() {
  DetectionFrame out;
  out.sensor_label = "short";
  out.is_3d = false;
  out.max_range = 0.1;
  out.fov_yaw = 0.5;
  return out;
}

/// The things that landmarks near each place stand for.
std::vector<int> mapped_things(Groups& world, double extent, bool with_another = false) {
  AssociationOptions options;
  options.extent = {extent};
  options.method = AssociationOptions::Method::kJcbb;
  options.motion.moving = {0};
  LandmarkMapper<SE2> mapper{LandmarkAssociation(options)};
  for (int i = 0; i < 120; ++i) {
    const SE2 motion = i == 0 ? world.truth(0)
                              : world.truth(i - 1).between(world.truth(i)) *
                                    SE2(world.noisy(0.01), world.noisy(0.01), world.noisy(0.003));
    const double sigma = i == 0 ? 1e-3 : 0.01;
    std::vector<DetectionFrame> looks = {world.look(i)};
    if (with_another) looks.push_back(look_of_another());
    mapper.add(motion, Noise::diagonal(Eigen::Vector3d(sigma, sigma, 0.3 * sigma)), looks);
  }
  mapper.finish();
  std::vector<int> things(world.places.size());
  const auto sizes = mapper.sizes();
  for (const auto& [id, landmark] : mapper.landmarks()) {
    const Eigen::Vector3d at = point_at(mapper.smoother().values(), landmark.position);
    for (std::size_t k = 0; k < world.places.size(); ++k) {
      if ((at.head<2>() - world.places[k]).norm() < 1) things[k] += sizes.at(id).things;
    }
    EXPECT_EQ(sizes.at(id).extent, extent);
  }
  return things;
}

TEST(CountThings, OfGroupsThatCannotBeToldApart) {
  int right = 0, all = 0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Groups world(seed);
    const std::vector<int> things = mapped_things(world, 0.2);
    for (std::size_t k = 0; k < things.size(); ++k) {
      right += things[k] == world.counts[k] ? 1 : 0;
      ++all;
    }
  }
  EXPECT_GE(right, 0.9 * all) << "of " << all;
}

// It is the looks at a landmark that count, whichever sensor has looked last.
TEST(CountThings, ASensorThatSeesNothingOfItChangesNothing) {
  Groups alone(1), beside(1);
  EXPECT_EQ(mapped_things(beside, 0.2, true), mapped_things(alone, 0.2));
}

TEST(CountThings, ThingsApartAreSingleOnes) {
  Groups world(1);
  world.counts.assign(world.places.size(), 1);
  EXPECT_EQ(mapped_things(world, 0), world.counts);
  EXPECT_EQ(mapped_things(world, 0.2), world.counts);
}

TEST(CountThings, AKnownLandmarkStandsForNoFewerThings) {
  KnownMap known;
  known.identified = false;
  KnownLandmark landmark;
  landmark.sightings = 5;
  landmark.existence = 3;
  landmark.covariance.diagonal().setConstant(1e-4);
  landmark.size = {0.3, 4};
  known.landmarks = {landmark};
  LandmarkAssociation association;
  association.adopt(known, false);
  const Values values;
  const Assignment assignment;
  const LandmarkRegistry landmarks;
  MapView map{values, assignment, landmarks};
  map.holds = [](Key) { return false; };
  const auto sizes = association.sizes(map);
  ASSERT_EQ(sizes.size(), 1U);
  EXPECT_EQ(sizes.at(0).things, 4);
  EXPECT_EQ(sizes.at(0).extent, 0.3);
}

}  // namespace
}  // namespace hybrid
