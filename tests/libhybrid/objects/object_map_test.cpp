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
  for (std::size_t c = 0; c < result.decisions.size(); ++c) {
    wrong += result.decisions[c].accepted() != (c % 2 == 0);
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

/// A camera that goes around three tags, with noise of its odometry and, in the tangent of the tag,
/// of the detections.
ObjectSequence with_odometry_of(double metres, double radians) {
  std::mt19937 random(5);
  ObjectSequence sequence;
  for (int i = 0; i < 150; ++i) {
    const double angle = 0.01 * i;
    sequence.truth.emplace_back(Eigen::Vector3d(2 * std::sin(angle), 0.0, 2 - 2 * std::cos(angle)),
                                SO3::exp({0.0, -angle, 0.0}));
    const SE3 error = SE3::exp(draw(random, metres, radians));
    sequence.odometry.push_back(i == 0
                                    ? SE3()
                                    : sequence.odometry.back() *
                                          sequence.truth[i - 1].between(sequence.truth[i]) * error);
    sequence.times.push_back(0.1 * i);
  }
  const std::vector<Eigen::Vector3d> tags = {{0.5, 0.1, 2.0}, {-0.6, 0.0, 2.2}, {0.1, -0.3, 1.8}};
  for (const Eigen::Vector3d& at : tags) {
    ObjectTrack track;
    for (const SE3& camera : sequence.truth) {
      track.truth.emplace_back(camera.between(SE3(at, SO3())));
      track.sightings.emplace_back(*track.truth.back() * SE3::exp(draw(random, 0.005, 0.015)));
    }
    for (std::size_t i = 0; i < 150; i += 10) {
      track.sightings[i] = SE3({0.3, 0.0, 0.5}, SO3()) * *track.sightings[i];
    }
    sequence.objects.push_back(track);
  }
  return sequence;
}

TEST(ObjectNoise, OdometryIsMeasuredByWhatObjectsHaveInCommon) {
  const ObjectSequence sequence = with_odometry_of(0.01, 0.005);
  const ObjectNoise noise = measure_noise(sequence, stated_noise(sequence));
  ASSERT_TRUE(noise.odometry_measured);
  EXPECT_GT(noise.step_m, 0.01 / 1.5);
  EXPECT_LT(noise.step_m, 0.01 * 1.5);
  EXPECT_GT(noise.step_rad, 0.005 / 2);
  EXPECT_LT(noise.step_rad, 0.005 * 2);
  for (const SightingNoise& s : noise.sightings) {
    EXPECT_NEAR(s.across_m, 0.005, 0.003);
    EXPECT_NEAR(s.along_m, 0.005, 0.003);
    EXPECT_NEAR(s.angle_rad, 0.015, 0.004);
    EXPECT_EQ(s.repetitions, 1.0);
  }
}

TEST(ObjectNoise, OdometryOfWheelsRejectsNoTrueDetections) {
  const ObjectSequence sequence = with_odometry_of(0.01, 0.005);
  const ObjectNoise noise = measure_noise(sequence, stated_noise(sequence));
  const RobustProblem problem = object_problem(sequence, noise);
  const RobustResult result = count_repetitions(sequence, noise, solve_objects(problem));
  int right = 0, wrong = 0;
  for (std::size_t c = 0; c < result.decisions.size(); ++c) {
    const bool is_false = c % 150 % 10 == 0;
    (is_false ? wrong : right) += result.decisions[c].accepted() ? 1 : 0;
  }
  EXPECT_GE(right, 365) << "of 405";
  EXPECT_EQ(wrong, 0) << "of 45";
  const ObjectMapErrors errors = object_map_errors(sequence, result.values);
  const ObjectMapErrors stated =
      object_map_errors(sequence, solve_objects(object_problem(sequence)).values);
  EXPECT_LT(mean(errors.object_m), 0.02);
  EXPECT_GT(mean(stated.object_m), 2 * mean(errors.object_m));
}

/// Detections whose errors are those of the view: they change over a hundred frames.
TEST(ObjectNoise, ErrorsThatLastAreNotTakenForMotionOfTheCamera) {
  std::mt19937 random(9);
  ObjectSequence sequence = simulate(400);
  for (ObjectTrack& track : sequence.objects) {
    SE3::Tangent lasting = draw(random, 0.02, 0.03);
    for (std::size_t i = 0; i < 400; ++i) {
      lasting = 0.99 * lasting + draw(random, 0.02, 0.03) * std::sqrt(1 - 0.99 * 0.99);
      track.sightings[i] = *track.truth[i] * SE3::exp(lasting + draw(random, 0.003, 0.01));
    }
  }
  const ObjectNoise noise = measure_noise(sequence, stated_noise(sequence));
  EXPECT_FALSE(noise.odometry_measured);
  for (const SightingNoise& s : noise.sightings) EXPECT_GT(s.repetitions, 20.0);
  const RobustProblem problem = object_problem(sequence, noise);
  const ObjectMapErrors start = object_map_errors(sequence, problem.initial);
  const ObjectMapErrors ours = object_map_errors(
      sequence, count_repetitions(sequence, noise, solve_objects(problem)).values);
  const ObjectMapErrors stated =
      object_map_errors(sequence, solve_objects(object_problem(sequence)).values);
  EXPECT_LT(ours.trajectory_m, 1.1 * start.trajectory_m + 1e-4);
  EXPECT_GT(stated.trajectory_m, 2.0 * ours.trajectory_m);
}

TEST(ObjectNoise, WhatIsNotToldIsAsStated) {
  ObjectSequence sequence = simulate(10);
  const ObjectNoise noise = measure_noise(sequence, stated_noise(sequence));
  EXPECT_FALSE(noise.odometry_measured);
  EXPECT_FALSE(noise.sightings_measured[0]);
  EXPECT_EQ(noise.sightings[0].along_m, 0.01);
  sequence = with_odometry_of(0.0, 0.0);
  for (ObjectTrack& track : sequence.objects) {
    for (std::size_t i = 0; i < 150; ++i) track.sightings[i] = track.truth[i];
  }
  EXPECT_GE(measure_noise(sequence, stated_noise(sequence)).sightings[0].along_m, 0.001)
      << "what has no noise at all is not taken for exact";
}

class PublicObjects : public ::testing::TestWithParam<const char*> {};

TEST_P(PublicObjects, NoWorseThanTheStartHuberAndCauchy) {
  const std::string folder = testing::data_path(std::string("ycbv_object_slam/") + GetParam());
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const ObjectSequence sequence = read_object_sequence(folder);
  const ObjectNoise noise = measure_noise(sequence, stated_noise(sequence));
  const RobustProblem problem = object_problem(sequence, noise);
  const ObjectMapErrors ours = object_map_errors(
      sequence, count_repetitions(sequence, noise, solve_objects(problem)).values);
  const ObjectMapErrors start = object_map_errors(sequence, problem.initial);
  EXPECT_LT(ours.trajectory_m, 1.02 * start.trajectory_m);
  EXPECT_LT(mean(ours.object_m), 1.02 * mean(start.object_m));
  // The kernels once with what is stated, once with what is measured.
  for (const RobustProblem& with : {object_problem(sequence), problem}) {
    for (const Loss& loss : {Loss::huber(), Loss::cauchy()}) {
      const ObjectMapErrors other = object_map_errors(sequence, solve_objects(with, loss).values);
      EXPECT_LT(ours.trajectory_m, 1.05 * other.trajectory_m);
      EXPECT_LT(mean(ours.object_m), mean(other.object_m));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Ycbv, PublicObjects, ::testing::Values("0001", "0014", "0017", "0025"),
                         [](const auto& instance) {
                           return "Sequence" + std::string(instance.param);
                         });

}  // namespace
}  // namespace hybrid
