// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A manifold of your own as a variable: the time offset and rate of a clock, where rates multiply.
// In batch, and online.
#include <cmath>
#include <iostream>
#include <memory>
#include <vector>

#include "libhybrid/factors/auto_diff_factor.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/smoother/incremental.h"
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

using ReadingFactor = hybrid::AutoDiffFactor<1, Reading, Clock>;

int main() {
  using namespace hybrid;
  const Key key('t', 0);
  const auto prior =
      std::make_shared<Prior<Clock>>(key, Clock(), Noise::diagonal(Eigen::Vector2d(10, 0.1)));
  std::vector<ContinuousFactorPtr> readings;
  for (double time = 0; time < 100; time += 10) {
    readings.push_back(std::make_shared<ReadingFactor>(
        std::array<Key, 1>{key}, Reading{time, 3 + 1.01 * time}, Noise::isotropic(1, 0.05)));
  }

  HybridGraph graph;
  graph.add(prior);
  for (const ContinuousFactorPtr& reading : readings) graph.add(reading);
  Estimate initial;
  initial.values.insert(key, Clock());
  const Estimate best = alternate(graph, initial).estimate;
  const Clock clock = best.values.at<Clock>(key);
  const Eigen::MatrixXd covariance = ContinuousMarginals(graph, best).covariance(key);
  std::cout << "offset " << clock.offset << " s, rate " << clock.rate << ", sigma of its logarithm "
            << std::sqrt(covariance(1, 1)) << '\n';

  // [online]
  IncrementalSmoother smoother;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    Delta delta;  // what is new: taken as a whole, or not at all
    if (i == 0) {
      delta.values.insert(key, Clock());
      delta.continuous.push_back(prior);
    }
    delta.continuous.push_back(readings[i]);
    const UpdateReport report = smoother.update(delta);
    if (report.status != UpdateReport::Status::kOk) {
      std::cerr << report.message << '\n';
      return 1;
    }
  }
  smoother.converge();
  const Clock online = smoother.values().at<Clock>(key);
  std::cout << "online: rate " << online.rate << ", sigma of its logarithm "
            << std::sqrt(smoother.joint_covariance({key})(1, 1)) << '\n';
  // [online]
  return std::abs(clock.rate - 1.01) < 1e-3 && std::abs(online.rate - clock.rate) < 1e-6 ? 0 : 1;
}
