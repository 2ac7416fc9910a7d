// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/initialization/direction_tracker.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/geometry/polar.h"

namespace hybrid {
namespace {

constexpr double kSigma = 0.01;              // rad
constexpr double kStep = 0.2, kTurn = 0.01;  // m, rad a frame
constexpr double kDrift = 0.002;             // m and rad a frame

/// A robot that drives a bend and sees points by direction; what it knows of its motion is noisy.
struct Walk {
  explicit Walk(bool in_space, unsigned seed = 1) : is_3d(in_space), random(seed) {}

  bool is_3d;
  std::mt19937 random;
  Eigen::Isometry3d T_robot_sensor = to_isometry(SE2(0.3, 0.1, 0.2));
  Eigen::Isometry3d robot = Eigen::Isometry3d::Identity();
  DirectionTracker tracker;
  int frames = 0;

  double gauss(double sigma) { return std::normal_distribution<double>(0, sigma)(random); }

  Eigen::Vector3d from_sensor(const Eigen::Vector3d& p) const {
    return to_polar(Eigen::Vector3d(compose(robot, T_robot_sensor).inverse() * p));
  }

  void step() {
    robot = compose(robot, to_isometry(SE2(kStep, 0, kTurn)));
    SE3::Tangent variances = SE3::Tangent::Zero();
    variances[0] = variances[1] = variances[5] = kDrift * kDrift;
    const SE2 measured(kStep + gauss(kDrift), gauss(kDrift), kTurn + gauss(kDrift));
    tracker.move(to_isometry(measured), variances.asDiagonal());
    ++frames;
  }

  Detection seen(const Eigen::Vector3d& p, std::int64_t true_id, std::vector<double> classes = {}) {
    const Eigen::Vector3d z = from_sensor(p);
    Detection d;
    d.yaw = z[1] + gauss(kSigma);
    d.pitch = is_3d ? z[2] + gauss(kSigma) : 0;
    d.covariance(1, 1) = kSigma * kSigma;
    if (is_3d) d.covariance(2, 2) = kSigma * kSigma;
    d.true_id = true_id;
    d.class_probabilities = std::move(classes);
    return d;
  }

  void look(std::vector<Detection> detections) {
    DetectionFrame frame;
    frame.time = 1 + 0.2 * frames;
    frame.sensor_label = "CAMERA";
    frame.T_robot_sensor = T_robot_sensor;
    frame.is_3d = is_3d;
    frame.has_range = false;
    frame.detections = std::move(detections);
    tracker.take(frame);
  }
};

TEST(DirectionTracker, CrossingDirectionsTellARangeAndItsNoise) {
  for (const bool is_3d : {false, true}) {
    const int n = is_3d ? 3 : 2;
    double squares = 0;
    int count = 0;
    for (unsigned seed = 1; seed <= 60; ++seed) {
      Walk walk(is_3d, seed);
      const Eigen::Vector3d p(4, 5, is_3d ? 1 : 0);
      for (int i = 0; i < 15; ++i) {
        if (i > 0) walk.step();
        walk.look({walk.seen(p, 3)});
      }
      const std::vector<DetectionFrame> out = walk.tracker.release();
      ASSERT_EQ(out.size(), 1U);
      EXPECT_TRUE(out[0].has_range);
      ASSERT_EQ(out[0].detections.size(), 1U);
      const Detection& d = out[0].detections[0];
      EXPECT_EQ(d.members.size(), 15U);
      const Eigen::Vector3d z = walk.from_sensor(p);
      const Eigen::VectorXd e = (Eigen::Vector3d(d.range, d.yaw, d.pitch) - z).head(n);
      EXPECT_LT(std::sqrt(d.covariance(0, 0)), 0.15 * d.range);
      squares += e.dot(d.covariance.topLeftCorner(n, n).llt().solve(e));
      ++count;
      EXPECT_TRUE(d.at_rest);
    }
    // Three sigmas of a chi-square distribution to both sides.
    const double mean = squares / (n * count), spread = std::sqrt(2.0 / (n * count));
    EXPECT_NEAR(mean, 1, 3 * spread + 0.2) << (is_3d ? "in space" : "in the plane");
  }
}

TEST(DirectionTracker, WhatIsStraightAheadTellsNoRange) {
  Walk walk(false);
  walk.T_robot_sensor = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 10; ++i) {
    if (i > 0) walk.step();
    const Eigen::Vector3d ahead = walk.robot * Eigen::Vector3d(60 - kStep * i, 0, 0);
    walk.look({walk.seen(ahead, 1)});
  }
  EXPECT_TRUE(walk.tracker.release().empty());
  EXPECT_EQ(walk.tracker.taken(), 10U);
  EXPECT_EQ(walk.tracker.released(), 0U);
}

TEST(DirectionTracker, NoDirectionCountsTwice) {
  Walk walk(false);
  const Eigen::Vector3d p(3, 4, 0);
  std::size_t members = 0, releases = 0;
  for (int i = 0; i < 30; ++i) {
    if (i > 0) walk.step();
    walk.look({walk.seen(p, 3)});
    for (const DetectionFrame& frame : walk.tracker.release()) {
      members += frame.detections.at(0).members.size();
      ++releases;
    }
  }
  EXPECT_GE(releases, 2U);
  EXPECT_LE(members, 30U);
  EXPECT_EQ(members, walk.tracker.released());
}

/// Two things that the robot passes change places in the image; their classes differ.
TEST(DirectionTracker, NeighboursAreToldApart) {
  Walk walk(false, 5);
  const Eigen::Vector3d near(4, 3, 0), far(6, 8, 0);
  std::size_t right = 0, all = 0;
  for (int i = 0; i < 25; ++i) {
    if (i > 0) walk.step();
    std::vector<Detection> both{walk.seen(near, 1, {0.8, 0.2}), walk.seen(far, 2, {0.2, 0.8})};
    if (i % 2 == 1) std::swap(both[0], both[1]);
    walk.look(both);
    for (const DetectionFrame& frame : walk.tracker.release()) {
      for (const Detection& d : frame.detections) {
        const bool is_near = d.class_probabilities.at(0) > 0.5;
        for (const auto& member : d.members) {
          ++all;
          right += *member == (is_near ? 1 : 2) ? 1 : 0;
        }
        const Eigen::Vector3d z = walk.from_sensor(is_near ? near : far);
        // Errors of inverse ranges are Gaussian, those of ranges only where they are small.
        const double sigma = std::sqrt(d.covariance(0, 0)) / (d.range * d.range);
        EXPECT_LT(std::abs(1 / d.range - 1 / z[0]), 4 * sigma);
      }
    }
  }
  EXPECT_GT(all, 30U);
  EXPECT_EQ(right, all);
}

TEST(DirectionTracker, WhatIsNotSeenAnyMoreIsGivenUp) {
  Walk walk(false);
  walk.look({walk.seen(Eigen::Vector3d(4, 5, 0), 3)});
  EXPECT_EQ(walk.tracker.followed(), 1U);
  constexpr int kLongerThanMemory = 105;  // frames, of 0.2 s
  for (int i = 0; i < kLongerThanMemory; ++i) {
    walk.step();
    walk.look({});
  }
  EXPECT_EQ(walk.tracker.followed(), 0U);
}

TEST(DirectionTracker, AnIdContinuesItsOwnTrackOnly) {
  Walk walk(false);
  const Eigen::Vector3d a(4, 5, 0), b(4.1, 5, 0);
  for (int i = 0; i < 15; ++i) {
    if (i > 0) walk.step();
    std::vector<Detection> both{walk.seen(a, 1), walk.seen(b, 2)};
    both[0].id = 1;
    both[1].id = 2;
    walk.look(both);
  }
  const std::vector<DetectionFrame> out = walk.tracker.release();
  ASSERT_EQ(out.size(), 1U);
  ASSERT_EQ(out[0].detections.size(), 2U);
  for (const Detection& d : out[0].detections) {
    for (const auto& member : d.members) EXPECT_EQ(member, d.id);
  }
}

}  // namespace
}  // namespace hybrid
