// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>

#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/projection.h"
#include "libhybrid/hybrid/graph.h"
#include "tests/support/random.h"

namespace hybrid::testing {

/// A simulated bundle adjustment: cameras c0, c1, ... with one calibration k0 see points p0, p1,
/// ... Priors on the first two cameras fix frame and scale.
struct SimulatedBundle {
  HybridGraph graph;
  Estimate initial;
  Values truth;
  int observations = 0;
};

struct BundleOptions {
  int cameras = 20;
  int points = 300;
  double pixel_noise = 0.5;
  /// Cameras around the points that look at their centre; else they move sideways along a wall that
  /// they face, so that focal length and distance are not determined.
  bool around = true;
  Intrinsics intrinsics = (Intrinsics() << 520, 325, 238, -0.12, 0.03).finished();
  Intrinsics start = (Intrinsics() << 600, 320, 240, 0, 0).finished();
};

/// The pose of a camera at `from`: z axis toward the target, y axis roughly downward.
inline SE3 looking_at(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d z = (to - from).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return {from, Eigen::Quaterniond(R)};
}

inline SimulatedBundle simulate_bundle(const BundleOptions& options, std::uint64_t seed) {
  SimulatedBundle s;
  Random random(seed);
  const Key calibration('k', 0);
  s.truth.insert(calibration, options.intrinsics);
  s.initial.values.insert(calibration, options.start);
  for (int i = 0; i < options.cameras; ++i) {
    const double turn = 2.0 * M_PI * i / options.cameras;
    const Eigen::Vector3d around(5.0 * std::cos(turn), 5.0 * std::sin(turn),
                                 1.5 * std::sin(3.0 * turn));
    const Eigen::Vector3d sideways(0.2 * i, -5.0, 0.3 * std::sin(i));
    const SE3 pose = options.around ? looking_at(around, random.vector<3>(0.3))
                                    : looking_at(sideways, sideways + Eigen::Vector3d::UnitY());
    const Key key('c', i);
    s.truth.insert(key, pose);
    s.initial.values.insert(key,
                            pose * SE3(random.vector<3>(0.05), SO3::exp(random.vector<3>(0.01))));
    if (i < 2) {
      s.graph.emplace<Prior<SE3>>(key, pose, Noise::isotropic(6, 1e-4));
      s.initial.values.update(key, pose);
    }
  }
  for (int k = 0; k < options.points; ++k) {
    const Eigen::Vector3d p = options.around
                                  ? random.vector<3>(0.9)
                                  : Eigen::Vector3d(random.uniform(-2, 2 + 0.2 * options.cameras),
                                                    0.0, random.uniform(-2, 2));
    const Key key('p', k);
    int seen = 0;
    for (int i = 0; i < options.cameras; ++i) {
      const SE3 pose = s.truth.at<SE3>(Key('c', i));
      const Eigen::Vector3d in_camera = pose.inverse() * p;
      if (in_camera.z() < 0.5) continue;
      const Eigen::Vector2d pixel = PinholeView(in_camera, options.intrinsics, false).pixel;
      if (pixel.minCoeff() < 0 || pixel.x() > 640 || pixel.y() > 480) continue;
      s.graph.emplace<Projection>(Key('c', i), key, calibration,
                                  pixel + random.vector<2>(options.pixel_noise),
                                  Noise::isotropic(2, options.pixel_noise));
      ++seen;
    }
    s.observations += seen;
    if (seen == 0) continue;
    s.truth.insert(key, p);
    s.initial.values.insert(key, Eigen::Vector3d(p + random.vector<3>(0.1)));
  }
  return s;
}

}  // namespace hybrid::testing
