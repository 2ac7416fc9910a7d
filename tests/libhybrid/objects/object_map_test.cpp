// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/objects/object_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "tests/support/data_path.h"

namespace hybrid {
namespace {

const std::vector<SE3> kObjects = {SE3({0.5, 0.0, 1.0}, SO3::exp({0.3, -0.2, 0.5})),
                                   SE3({-0.4, 0.1, 1.2}, SO3())};

SE3::Tangent draw(std::mt19937& random, double metres, double radians) {
  std::normal_distribution<double> normal;
  SE3::Tangent v;
  for (int i = 0; i < 6; ++i) v(i) = (i < 3 ? metres : radians) * normal(random);
  return v;
}

/// A camera on an arc around two objects. Every other detection is false: off by the same 0.4 m
/// while the camera is on one side of the arc, as a detector that sees a wrong face would be.
ObjectSequence simulate(int frames) {
  std::mt19937 random(3);
  ObjectSequence sequence;
  SE3 odometry;
  for (int i = 0; i < frames; ++i) {
    const double angle = 0.01 * i;
    sequence.truth.emplace_back(Eigen::Vector3d(std::sin(angle), 0.0, 1.0 - std::cos(angle)),
                                SO3::exp({0.0, -angle, 0.0}));
    if (i > 0) {
      const SE3 step = sequence.truth[i - 1].between(sequence.truth[i]);
      odometry = odometry * step * SE3::exp(draw(random, 1e-4, 1e-4));
    }
    sequence.odometry.push_back(odometry);
    sequence.times.push_back(0.1 * i);
  }
  for (const SE3& object : kObjects) {
    ObjectTrack track;
    for (int i = 0; i < frames; ++i) {
      const SE3 seen = sequence.truth[i].between(object);
      track.truth.emplace_back(seen);
      SE3 sighting = seen * SE3::exp(draw(random, 0.005, 0.015));
      if (i % 2 == 1) {
        const double side = i < frames / 2 ? 0.4 : 0.15;
        sighting = SE3({0.0, 0.0, side}, SO3()) * sighting * SE3::exp(draw(random, 0.03, 0.1));
      }
      track.sightings.emplace_back(sighting);
    }
    sequence.objects.push_back(track);
  }
  return sequence;
}

double mean(const std::vector<double>& x) {
  double sum = 0.0;
  for (double e : x) sum += e;
  return sum / static_cast<double>(x.size());
}

TEST(ObjectMap, FalseDetectionsAreSwitchedOff) {
  const ObjectSequence sequence = simulate(120);
  const RobustProblem problem = object_problem(sequence);
  ASSERT_EQ(problem.closures.size(), 240u);
  const RobustResult result = solve_objects(problem);
  EXPECT_TRUE(result.converged) << result.message;
  int wrong = 0;
  for (std::size_t c = 0; c < result.verdicts.size(); ++c) {
    wrong += result.verdicts[c].accepted != (c % 2 == 0);
  }
  EXPECT_LE(wrong, 2);
  const ObjectMapErrors errors = object_map_errors(sequence, result.values);
  EXPECT_LT(errors.trajectory_m, 0.003);
  EXPECT_LT(mean(errors.object_m), 0.005);
  const ObjectMapErrors huber =
      object_map_errors(sequence, solve_objects(problem, Loss::huber()).values);
  EXPECT_GT(mean(huber.object_m), 2.0 * mean(errors.object_m));
}

TEST(ObjectMap, ObjectsNeverSeenAreLeftOut) {
  ObjectSequence sequence = simulate(120);
  for (auto& sighting : sequence.objects[1].sightings) sighting.reset();
  const RobustResult result = solve_objects(object_problem(sequence));
  EXPECT_TRUE(result.converged) << result.message;
  EXPECT_FALSE(result.values.contains(object_key(1)));
  const ObjectMapErrors errors = object_map_errors(sequence, result.values);
  EXPECT_LT(errors.object_m[0], 0.01);
  EXPECT_TRUE(std::isnan(errors.object_m[1]));
}

TEST(ObjectMap, BadInputIsRefused) {
  ObjectSequence sequence = simulate(5);
  ObjectMapOptions options;
  options.sighting_m = 0.0;
  EXPECT_THROW(object_problem(sequence, options), Error);
  const Values values = object_problem(sequence).initial;
  sequence.truth.clear();
  EXPECT_THROW(object_map_errors(sequence, values), Error);
}

class PublicObjects : public ::testing::TestWithParam<const char*> {};

TEST_P(PublicObjects, BetterThanHuberAndCauchy) {
  const std::string folder = testing::data_path(std::string("ycbv_object_slam/") + GetParam());
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const ObjectSequence sequence = read_object_sequence(folder);
  const RobustProblem problem = object_problem(sequence);
  const ObjectMapErrors ours = object_map_errors(sequence, solve_objects(problem).values);
  for (const Loss& loss : {Loss::huber(), Loss::cauchy()}) {
    const ObjectMapErrors other = object_map_errors(sequence, solve_objects(problem, loss).values);
    EXPECT_LT(ours.trajectory_m, other.trajectory_m);
    EXPECT_LT(mean(ours.object_m), mean(other.object_m));
    EXPECT_LT(mean(ours.object_deg), mean(other.object_deg));
  }
}

INSTANTIATE_TEST_SUITE_P(Ycbv, PublicObjects, ::testing::Values("0001", "0014", "0017", "0025"),
                         [](const auto& instance) {
                           return "Sequence" + std::string(instance.param);
                         });

}  // namespace
}  // namespace hybrid
