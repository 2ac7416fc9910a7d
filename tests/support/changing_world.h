// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/hybrid/semantic.h"
#include "libhybrid/hybrid/weighted.h"
#include "libhybrid/smoother/incremental.h"
#include "tests/support/random.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid::testing {

inline Key landmark(int l) {
  return {'l', static_cast<std::uint64_t>(l)};
}
inline DiscreteKey closure_switch(int i) {
  return {Key('d', static_cast<std::uint64_t>(i)), 2};
}
inline DiscreteKey mode(int i) {
  return {Key('m', static_cast<std::uint64_t>(i)), 2};
}
inline DiscreteKey class_of(int l) {
  return {Key('s', static_cast<std::uint64_t>(l)), 3};
}

inline ContinuousFactorPtr between(int i, int j, const SE2& z, double sigma) {
  return std::make_shared<BetweenSE2>(pose(i), pose(j), z, Noise::isotropic(3, sigma));
}

/// A robot that drives in circles and sometimes slips, with landmarks of a class, closures that may
/// be false, and removals: every kind of change that a smoother accepts.
class ChangingWorld {
 public:
  explicit ChangingWorld(int seed) : random_(seed) {}

  void seed(int seed) { random_ = Random(seed); }

  /// Applies one more change to the smoother and returns its report.
  UpdateReport step(IncrementalSmoother& smoother) {
    Delta delta;
    const int k = next_;
    if (k == 0) {
      delta.values.insert(pose(0), SE2());
      delta.continuous.push_back(
          std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.01)));
    } else {
      move(k, smoother, delta);
      if (k > 3 && random_.below(2) == 0) close_loop(k, delta);
      if (random_.below(2) == 0) see_landmark(k, smoother, delta);
      if (!removable_.empty() && random_.below(3) == 0) {
        const std::size_t at = random_.below(static_cast<int>(removable_.size()));
        delta.remove.push_back(removable_[at]);
        removable_.erase(removable_.begin() + static_cast<std::ptrdiff_t>(at));
      }
    }
    const UpdateReport report = smoother.update(delta);
    if (report.status != UpdateReport::Status::kOk) return report;
    ++next_;
    for (Handle handle : report.handles.hybrid) {
      if (closures_ > 0 &&
          smoother.graph().hybrid().at(handle)->discrete_keys()[0].key.letter() == 'd')
        removable_.push_back(handle);
    }
    return report;
  }

 private:
  void move(int k, const IncrementalSmoother& smoother, Delta& delta) {
    const SE2 motion(1.0, 0.0, 0.3);
    const SE2 z = motion * random_.value<SE2>(0.03);
    delta.values.insert(pose(k), smoother.values().at<SE2>(pose(k - 1)) * z);
    std::vector<MixtureComponent> modes = {{between(k - 1, k, z, 0.05), 0.0, false},
                                           {between(k - 1, k, SE2(), 0.05), 0.0, false}};
    delta.hybrid.push_back(
        std::make_shared<Mixture>(std::vector<DiscreteKey>{mode(k)}, std::move(modes)));
    delta.discrete.push_back(k == 1 ? prior_table(mode(1), {0.9, 0.1})
                                    : transition_table(mode(k - 1), mode(k), {0.9, 0.1, 0.2, 0.8}));
  }
  void close_loop(int k, Delta& delta) {
    const int old = random_.below(k - 2);
    SE2 z = SE2(1.0, 0.0, 0.3 * (k - old)) * random_.value<SE2>(0.5);
    delta.hybrid.push_back(
        make_outlier_mixture(closure_switch(closures_++), between(old, k, z, 0.2),
                             between(old, k, z, 0.2 * std::sqrt(1e7)), 0.7, 0.3));
  }
  void see_landmark(int k, const IncrementalSmoother& smoother, Delta& delta) {
    const int l = random_.below(4);
    const Eigen::Vector2d z(2.0 + random_.uniform(), random_.uniform(-1.0, 1.0));
    if (!smoother.values().contains(landmark(l))) {
      const SE2 x = delta.values.at<SE2>(pose(k));
      const Eigen::Vector2d seen(z[0] * std::cos(z[1]), z[0] * std::sin(z[1]));
      delta.values.insert(landmark(l), Eigen::Vector2d(x * seen));
      delta.discrete.push_back(prior_table(class_of(l), {0.5, 0.3, 0.2}));
    }
    delta.hybrid.push_back(std::make_shared<WeightedFactor>(
        std::make_shared<BearingRange<SE2>>(pose(k), landmark(l), z, Noise::isotropic(2, 0.3)),
        likelihood_table(class_of(l), {0.2, 0.7, 0.1})));
  }

  Random random_;
  int next_ = 0;
  int closures_ = 0;
  std::vector<Handle> removable_;
};

/// The whole state of a smoother as numbers.
inline std::vector<double> state(const IncrementalSmoother& smoother) {
  std::vector<double> all = {smoother.objective(), smoother.constant(), smoother.cost(),
                             smoother.tree().log_determinant(),
                             static_cast<double>(smoother.graph().size())};
  for (Key key : smoother.values().keys()) {
    const double* x = smoother.values().data(key);
    all.insert(all.end(), x, x + smoother.values().type(key).size);
    for (Handle handle : smoother.factors_of(key)) all.push_back(handle.index);
  }
  for (const DiscreteKey& key : smoother.graph().discrete_keys()) {
    all.push_back(static_cast<double>(key.key.packed()));
    all.push_back(smoother.assignment().at(key.key));
    for (const Table* table : smoother.component(key.key))
      all.insert(all.end(), table->costs().begin(), table->costs().end());
  }
  smoother.visit_covariances([&](Key, const Eigen::MatrixXd& covariance) {
    all.insert(all.end(), covariance.data(), covariance.data() + covariance.size());
  });
  for (int v : smoother.tree().cliques().order()) all.push_back(v);
  return all;
}

}  // namespace hybrid::testing
