// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/range.h"
#include "libhybrid/hybrid/graph.h"
#include "tests/support/random.h"

namespace hybrid::testing {

/// Measurements of the landmarks within range.
enum class Sensor {
  kBearingRange,
  kRange  ///< ranges; the first sighting of a landmark has a rough bearing too
};

struct WalkOptions {
  double noise = 1.0;  ///< factor on all standard deviations
  Sensor sensor = Sensor::kBearingRange;
  int landmarks = 25;
  double spread = 8.0;  ///< standard deviation of the landmarks' coordinates [m]
  double reach = 5.0;   ///< range of the sensor [m]
};

/// A robot that circles among identified landmarks, about once in 63 steps: one change of the graph
/// per step.
template <class Pose>
class SimulatedWalk {
 public:
  using Point = typename Pose::Point;
  static constexpr int kPointDim = Point::RowsAtCompileTime;

  SimulatedWalk(const WalkOptions& options, std::uint64_t seed) : options_(options), random_(seed) {
    for (int i = 0; i < options.landmarks; ++i)
      landmarks_.push_back(random_.vector<kPointDim>(options.spread));
    seen_.resize(landmarks_.size());
  }

  static Key pose(int i) { return {'x', static_cast<std::uint64_t>(i)}; }
  static Key landmark(std::size_t i) { return {'l', i}; }

  /// The next pose, initialised from the estimate of the last one, with its measurements.
  Delta step(const Values& estimate) {
    Delta delta;
    Pose start;
    const int t = t_++;
    if (t == 0) {
      delta.continuous.push_back(
          std::make_shared<Prior<Pose>>(pose(0), start, Noise::isotropic(Pose::kDim, 1e-3)));
    } else {
      const Pose motion = step_at(t);
      truth_ = truth_ * motion;
      truth_.normalize();
      const double sigma = 0.05 * options_.noise;
      const Pose z = motion * random_.value<Pose>(sigma);
      delta.continuous.push_back(std::make_shared<Between<Pose>>(
          pose(t - 1), pose(t), z, Noise::isotropic(Pose::kDim, sigma)));
      start = estimate.at<Pose>(pose(t - 1)) * z;
    }
    delta.values.insert(pose(t), start);
    for (std::size_t i = 0; i < landmarks_.size(); ++i) see(i, start, delta);
    return delta;
  }

  const Pose& truth() const { return truth_; }
  const Point& truth(std::size_t i) const { return landmarks_[i]; }
  int steps() const { return t_; }

 private:
  static SE2 forward(int, SE2*) { return {0.5, 0.0, 0.1}; }
  static SE3 forward(int t, SE3*) {
    SE3::Tangent v;
    v << 0.5, 0.0, 0.0, 0.05 * std::cos(0.2 * t), 0.05 * std::sin(0.3 * t), 0.1;
    return SE3::exp(v);
  }
  static Pose step_at(int t) { return forward(t, static_cast<Pose*>(nullptr)); }

  void see(std::size_t i, const Pose& start, Delta& delta) {
    const Point z = to_polar(Point(truth_.inverse() * landmarks_[i]));
    if (z[0] > options_.reach) return;
    Point sigma = Point::Constant(0.1 * options_.noise);
    sigma[0] = 0.3 * options_.noise;
    const bool ranges = options_.sensor == Sensor::kRange;
    if (ranges && !seen_[i]) sigma.template tail<kPointDim - 1>() *= 3.0;
    Point measured = z;
    for (int k = 0; k < kPointDim; ++k) measured[k] += random_.normal(sigma[k]);
    measured[0] = std::abs(measured[0]);
    const Key from = pose(t_ - 1), to = landmark(i);
    if (ranges && seen_[i]) {
      delta.continuous.push_back(std::make_shared<Range<Pose, Point>>(
          from, to, measured[0], Noise::isotropic(1, sigma[0])));
    } else {
      delta.continuous.push_back(std::make_shared<BearingRange<Pose>>(
          from, to, measured, Noise::diagonal(Eigen::VectorXd(sigma))));
    }
    if (!seen_[i]) delta.values.insert(to, Point(start * from_polar(measured)));
    seen_[i] = true;
  }

  WalkOptions options_;
  Random random_;
  std::vector<Point> landmarks_;
  std::vector<bool> seen_;
  Pose truth_;
  int t_ = 0;
};

}  // namespace hybrid::testing
