// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "libhybrid/geometry/polar.h"
#include "libhybrid/landmarks/landmark_mapper.h"

namespace hybrid {
namespace {

constexpr int kMoverFrames = 60;
constexpr double kPeriod = 0.5;           // [s]
constexpr double kSigmaRange = 0.1;       // [m]
constexpr double kSigmaYaw = 0.01;        // [rad]
constexpr std::int64_t kWalker = 100;     // true id
const Eigen::Vector2d kStart(3, -6);      // of the walker [m]
const Eigen::Vector2d kVelocity(0, 0.6);  // [m/s]

/// A robot on a circle among twelve posts and, if wanted, a slow walker that crosses the circle.
struct Yard {
  explicit Yard(unsigned seed) : random(seed) {
    for (int k = 0; k < 12; ++k) posts.emplace_back(9 * std::cos(k), 9 * std::sin(k) + 5);
  }
  double noisy(double sigma) { return sigma * std::normal_distribution<double>()(random); }
  static SE2 truth(int i) {
    const double angle = 0.06 * i;
    return {5 * std::sin(angle), 5 - 5 * std::cos(angle), angle};
  }

  std::optional<Detection> seen(int i, const Eigen::Vector2d& place, std::int64_t true_id) {
    const Eigen::Vector2d z = to_polar(Eigen::Vector2d(truth(i).inverse() * place));
    if (z[0] > 14) return std::nullopt;
    Detection d;
    d.range = z[0] + noisy(kSigmaRange);
    d.yaw = z[1] + noisy(kSigmaYaw);
    d.covariance.diagonal() << kSigmaRange * kSigmaRange, kSigmaYaw * kSigmaYaw, 0;
    d.true_id = true_id;
    return d;
  }

  LandmarkMapper<SE2> mapped(bool walker, const MotionPrior& motion = {}) {
    AssociationOptions options;
    options.motion = motion;
    LandmarkMapper<SE2> mapper{LandmarkAssociation(options)};
    for (int i = 0; i < kMoverFrames; ++i) {
      DetectionFrame frame;
      frame.time = 1000 + kPeriod * i;
      frame.is_3d = false;
      frame.max_range = 14;
      frame.fov_yaw = 2 * M_PI;
      for (std::size_t k = 0; k < posts.size(); ++k) {
        if (auto d = seen(i, posts[k], static_cast<std::int64_t>(k)))
          frame.detections.push_back(*d);
      }
      if (walker) {
        if (auto d = seen(i, kStart + kPeriod * i * kVelocity, kWalker)) {
          frame.detections.push_back(*d);
        }
      }
      const SE2 motion_to =
          i == 0 ? SE2()
                 : truth(i - 1).between(truth(i)) * SE2(noisy(0.02), noisy(0.02), noisy(0.005));
      mapper.add(motion_to, Noise::diagonal(Eigen::Vector3d(0.02, 0.02, 0.005)), {frame});
    }
    mapper.finish();
    return mapper;
  }

  std::mt19937 random;
  std::vector<Eigen::Vector2d> posts;
};

std::vector<double> times() {
  std::vector<double> out;
  for (int i = 0; i < kMoverFrames; ++i) out.push_back(1000 + kPeriod * i);
  return out;
}

std::size_t count(const LandmarkRegistry& landmarks) {
  return static_cast<std::size_t>(std::distance(landmarks.begin(), landmarks.end()));
}

TEST(LandmarkMovers, ASlowWalkerGetsATrajectoryAndNoLandmark) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Yard yard(seed);
    const LandmarkMapper<SE2> mapper = yard.mapped(true);
    EXPECT_EQ(count(mapper.landmarks()), yard.posts.size()) << seed;
    int sightings = 0, kept_out = 0;
    for (const AssociationDecision& d : mapper.decisions()) {
      if (d.true_id != kWalker) {
        EXPECT_FALSE(d.mover) << seed;
        continue;
      }
      ++sightings;
      kept_out += !d.estimated_id && d.mover ? 1 : 0;
    }
    EXPECT_GE(kept_out, 0.95 * sightings) << seed;
    const std::vector<Mover> movers = mapper.movers(times());
    ASSERT_EQ(movers.size(), 1U) << seed;
    EXPECT_GT(movers[0].probability, 0.99);
    double sum = 0;
    for (const MoverState& state : movers[0].states) {
      const Eigen::Vector2d place = kStart + (state.time - 1000) * kVelocity;
      sum += (state.position.head<2>() - place).norm();
      const double error = state.velocity.y() - kVelocity.y();
      EXPECT_LT(error * error, 16 * state.covariance(4, 4));
    }
    EXPECT_LT(sum / static_cast<double>(movers[0].states.size()), 0.2);
    EXPECT_GT(movers[0].states.size(), 30U);
  }
}

TEST(LandmarkMovers, WhereAllStandsTheMapIsThatOfNoMovers) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const LandmarkMapper<SE2> followed = Yard(seed).mapped(false);
    const LandmarkMapper<SE2> plain = Yard(seed).mapped(false, {{{10, 2}}, {0}});
    EXPECT_TRUE(followed.movers(times()).empty());
    EXPECT_EQ(count(followed.landmarks()), count(plain.landmarks()));
    EXPECT_EQ(followed.smoother().objective(), plain.smoother().objective());
  }
}

TEST(LandmarkMovers, WithoutAPriorOfMotionTheWalkerIsMapped) {
  Yard yard(1);
  const LandmarkMapper<SE2> mapper = yard.mapped(true, {{{10, 2}}, {0}});
  EXPECT_TRUE(mapper.movers(times()).empty());
  int mapped = 0;
  for (const AssociationDecision& d : mapper.decisions()) {
    mapped += d.true_id == kWalker && d.estimated_id ? 1 : 0;
  }
  EXPECT_GT(mapped, 3);
}

}  // namespace
}  // namespace hybrid
