// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A user-defined manifold as a variable: offset and rate of a clock; steps multiply the rate.
#include <cmath>
#include <iostream>

#include "libhybrid/factors/auto_diff_factor.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/solvers/alternating.h"

// [example]
/// A clock that shows offset + rate t: steps add to the offset [s] and multiply the rate.
struct Clock {
  static constexpr const char* kName = "clock";
  static constexpr int kDim = 2;   // of a step
  static constexpr int kSize = 2;  // doubles in storage
  using Tangent = Eigen::Vector2d;

  double offset = 0, rate = 1;

  static Clock load(const double* x) { return {x[0], x[1]}; }
  void store(double* x) const {
    x[0] = offset;
    x[1] = rate;
  }
  Clock retract(const Tangent& step) const { return {offset + step[0], rate * std::exp(step[1])}; }
  Tangent local(const Clock& other) const {
    return {other.offset - offset, std::log(other.rate / rate)};
  }
};
// [example]

/// The reading of the clock at a known time.
struct Reading {
  double time, shown;
  template <class S>
  Eigen::Matrix<S, 1, 1> operator()(const Eigen::Matrix<S, 2, 1>& clock) const {
    return Eigen::Matrix<S, 1, 1>(clock[0] + clock[1] * time - shown);
  }
};

int main() {
  using namespace hybrid;
  const Key key('t', 0);
  HybridGraph graph;
  graph.emplace<Prior<Clock>>(key, Clock(), Noise::diagonal(Eigen::Vector2d(10, 0.1)));
  for (double time = 0; time < 100; time += 10) {
    graph.emplace<AutoDiffFactor<1, Reading, Clock>>(
        std::array<Key, 1>{key}, Reading{time, 3 + 1.01 * time}, Noise::isotropic(1, 0.05));
  }
  Estimate initial;
  initial.values.insert(key, Clock());
  const Estimate best = alternate(graph, initial).estimate;
  const Clock clock = best.values.at<Clock>(key);
  const Eigen::MatrixXd covariance = ContinuousMarginals(graph, best).covariance(key);
  std::cout << "offset " << clock.offset << " s, rate " << clock.rate << ", sigma of its logarithm "
            << std::sqrt(covariance(1, 1)) << '\n';
  return std::abs(clock.rate - 1.01) < 1e-3 ? 0 : 1;
}
