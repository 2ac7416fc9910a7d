// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Things that a robot nearly touches.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "libhybrid/detections/sighting.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

constexpr double kAlong = 0.1, kAcross = 0.01;  // sigmas of a range [m] and a bearing [rad]
constexpr double kStep = 0.03, kTurn = 0.005;   // and of the odometry

Detection sighting(double range, double yaw) {
  Detection d;
  d.range = range;
  d.yaw = yaw;
  d.covariance = Eigen::Vector3d(kAlong * kAlong, kAcross * kAcross, 1e-4).asDiagonal();
  return d;
}

TEST(NearSighting, AllDirectionsAreAlike) {
  for (const bool is_3d : {false, true}) {
    for (const double range : {0.11, 0.2, 0.29}) {
      const Eigen::MatrixXd C = measured_point(sighting(range, 0.7), is_3d).covariance;
      for (Eigen::Index i = 1; i < C.rows(); ++i) {
        EXPECT_NEAR(range * std::sqrt(C(i, i)), kAlong, 0.01) << range;
      }
    }
    EXPECT_LE(measured_point(sighting(0.01, 0.7), is_3d).covariance(1, 1), 1.01);
  }
}

TEST(NearSighting, FartherThingsKeepTheirNoise) {
  const Detection d = sighting(0.31, 0.7);
  EXPECT_EQ(measured_point(d, true).covariance, Eigen::MatrixXd(d.covariance));
  EXPECT_EQ(measured_point(d, false).covariance,
            Eigen::MatrixXd(d.covariance.topLeftCorner<2, 2>()));
}

/// A robot drives past three landmarks, and over a fourth.
class DriveOver {
 public:
  explicit DriveOver(unsigned seed) : random_(seed) {
    landmarks_ = {{3, 4}, {6, -4}, {9, 4}, {6, gauss(0.05)}};
  }

  /// The optimum from the truth less what the smoother has reached, step by step: 0 at best.
  double left() {
    IncrementalSmoother smoother;
    for (int t = 0; t <= 12; ++t) smoother.update(step(t, smoother.values()));
    smoother.converge();
    const SolverResult best = levenberg_marquardt(smoother.graph(), {truth(smoother.values()), {}});
    return smoother.objective() - objective(smoother.graph(), best.values, smoother.assignment());
  }

 private:
  static Key pose(int t) { return {'x', static_cast<std::uint64_t>(t)}; }
  static SE2 place(int t) { return {double(t), 0, 0}; }
  double gauss(double sigma) { return sigma * std::normal_distribution<double>()(random_); }

  Values truth(const Values& like) const {
    Values out;
    for (int t = 0; like.contains(pose(t)); ++t) out.insert(pose(t), place(t));
    for (std::size_t k = 0; k < landmarks_.size(); ++k) {
      out.insert(position_key(std::int64_t(k)), landmarks_[k]);
    }
    return out;
  }

  Delta step(int t, const Values& estimate) {
    Delta delta;
    SE2 start;
    if (t == 0) {
      delta.continuous.push_back(
          std::make_shared<Prior<SE2>>(pose(0), start, Noise::isotropic(3, 0.01)));
    } else {
      const SE2 z(1 + gauss(kStep), gauss(kStep), gauss(kTurn));
      const Noise noise = Noise::diagonal(Eigen::Vector3d(kStep, kStep, kTurn));
      delta.continuous.push_back(std::make_shared<BetweenSE2>(pose(t - 1), pose(t), z, noise));
      start = estimate.at<SE2>(pose(t - 1)) * z;
    }
    delta.values.insert(pose(t), start);
    for (std::size_t k = 0; k < landmarks_.size(); ++k) sight(t, k, start, estimate, delta);
    return delta;
  }

  void sight(int t, std::size_t k, const SE2& start, const Values& estimate, Delta& delta) {
    const Eigen::Vector2d seen = place(t).inverse() * landmarks_[k];
    const double range = std::max(0.01, seen.norm() + gauss(kAlong));
    const Detection d = sighting(range, std::atan2(seen.y(), seen.x()) + gauss(kAcross));
    const Key key = position_key(std::int64_t(k));
    if (!estimate.contains(key)) {
      delta.values.insert(key,
                          Eigen::Vector2d(start * from_polar(Eigen::Vector2d(d.range, d.yaw))));
    }
    delta.continuous.push_back(sighting_factor(pose(t), key, {}, d, false));
  }

  std::mt19937 random_;
  std::vector<Eigen::Vector2d> landmarks_;
};

TEST(NearSighting, DoesNotHoldALandmarkOnTheWrongSide) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    EXPECT_LT(DriveOver(seed).left(), 1.0) << "seed " << seed;
  }
}

}  // namespace
}  // namespace hybrid
