// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A factor without derivatives: the distance of a robot to a wall, differentiated by dual numbers.
#include <iostream>

#include "libhybrid/factors/auto_diff_factor.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/solvers/alternating.h"

// [example]
/// The distance [m] from a robot to a straight wall n' p = d: residual d - n' t - z.
struct WallDistance {
  Eigen::Vector2d normal;
  double d, measured;

  /// `pose` is an SE2 as it is stored: x, y, cos, sin.
  template <class S>
  Eigen::Matrix<S, 1, 1> operator()(const Eigen::Matrix<S, 4, 1>& pose) const {
    return Eigen::Matrix<S, 1, 1>(d - normal[0] * pose[0] - normal[1] * pose[1] - measured);
  }
};
using WallFactor = hybrid::AutoDiffFactor<1, WallDistance, hybrid::SE2>;
// [example]

int main() {
  using namespace hybrid;
  const Key pose('x', 0);
  HybridGraph graph;
  graph.emplace<Prior<SE2>>(pose, SE2(0, 0, 0), Noise::isotropic(3, 1.0));
  graph.emplace<WallFactor>(std::array<Key, 1>{pose}, WallDistance{Eigen::Vector2d(1, 0), 5.0, 4.0},
                            Noise::isotropic(1, 0.01));
  Estimate initial;
  initial.values.insert(pose, SE2(0.3, 0.1, 0.2));
  const double x = alternate(graph, initial).estimate.values.at<SE2>(pose).x();
  std::cout << "the wall is 5 m away from the origin and 4 m from the robot: x = " << x << " m\n";
  return std::abs(x - 1) < 0.01 ? 0 : 1;
}
