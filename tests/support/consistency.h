// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Cholesky>

#include "libhybrid/smoother/window.h"
#include "tests/support/simulated_walk.h"

namespace hybrid::testing {

/// The error of an estimated pose. NEES is the normalised estimation error squared per degree of
/// freedom: 1 on average if the covariance is right, larger if it is too small.
struct PoseError {
  double nees = 0.0, heading_nees = 0.0;
  double distance = 0.0;  ///< [m]
  double angle = 0.0;     ///< [rad]
};

template <class Pose>
PoseError pose_error(const Pose& estimate, const Pose& truth, const Eigen::MatrixXd& covariance) {
  constexpr int kPosition = Pose::Point::RowsAtCompileTime;
  constexpr int kTurns = Pose::kDim - kPosition;
  const typename Pose::Tangent e = estimate.between(truth).log();
  const auto turn = e.template tail<kTurns>();
  const Eigen::MatrixXd of_turn = covariance.bottomRightCorner(kTurns, kTurns);
  return {e.dot(covariance.llt().solve(e)) / Pose::kDim,
          turn.dot(of_turn.llt().solve(turn)) / kTurns, e.template head<kPosition>().norm(),
          turn.norm()};
}

/// Runs a walk with a smoother and calls visit(step, smoother, error of the newest pose) after each
/// step.
template <class Pose, class Visit>
void walk(const WindowOptions& window, const WalkOptions& options, int steps, std::uint64_t seed,
          const Visit& visit) {
  WindowSmoother smoother(window);
  SimulatedWalk<Pose> world(options, seed);
  for (int t = 0; t < steps; ++t) {
    smoother.update(world.step(smoother.smoother().values()));
    const Key key = world.pose(t);
    visit(t, smoother,
          pose_error(smoother.smoother().values().template at<Pose>(key), world.truth(),
                     smoother.smoother().joint_covariance({key})));
  }
}

}  // namespace hybrid::testing
