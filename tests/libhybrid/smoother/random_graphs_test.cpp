// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Random graphs that grow, shrink and change their minds, against the batch solvers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/hybrid/semantic.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/solvers/alternating.h"
#include "tests/support/random.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::distance;
using testing::pose;
using testing::Random;
using testing::step_forward;

/// Graphs per test; HYBRID_TEST_CASES in the environment multiplies them.
int cases(int base) {
  const char* times = std::getenv("HYBRID_TEST_CASES");
  return times == nullptr ? base : base * std::max(1, std::atoi(times));
}

template <class Pose>
class World {
 public:
  using Point = typename Pose::Point;
  static constexpr int kPoint = Point::RowsAtCompileTime;

  explicit World(int seed) : random_(seed) {
    for (int l = 0; l < 8; ++l) landmarks_.push_back(random_.template vector<kPoint>(6.0));
    Delta delta;
    delta.values.insert(pose(0), Pose());
    delta.continuous.push_back(
        std::make_shared<Prior<Pose>>(pose(0), Pose(), Noise::isotropic(Pose::kDim, 0.01)));
    truth_.push_back(Pose());
    apply(delta);
  }

  void step() {
    Delta delta;
    remove_some(delta);
    add_pose(delta);
    if (random_.below(2) == 0) see_landmark(delta);
    if (random_.below(2) == 0) close_loop(delta);
    apply(delta);
  }

  /// The converged estimate is where the batch solvers stop too.
  void expect_equals_batch() {
    const Estimate start = smoother_.estimate();
    // A residual of about half a turn in space can make the system singular, which is reported.
    if (smoother_.converge(200, 1e-15).status != UpdateReport::Status::kOk) return;
    AlternatingOptions options;
    options.relative_decrease = 1e-15;
    options.continuous.relative_decrease = 1e-15;
    const AlternatingResult stay = alternate(smoother_.graph(), smoother_.estimate(), options);
    EXPECT_EQ(stay.estimate.assignment, smoother_.assignment());
    EXPECT_LT(distance(stay.estimate.values, smoother_.values()), 1e-6);
    EXPECT_NEAR(stay.report.objective, smoother_.objective(),
                1e-6 * std::max(1.0, std::abs(stay.report.objective)));
    const AlternatingResult batch = alternate(smoother_.graph(), start, options);
    if (!(batch.estimate.assignment == smoother_.assignment())) return;
    EXPECT_LT(distance(batch.estimate.values, smoother_.values()), 1e-6);
    ++equal_;
  }

  int flips() const { return flips_; }
  int equal() const { return equal_; }

 private:
  Noise noise(int dim) const { return Noise::isotropic(dim, 0.03); }
  Key landmark(int l) const { return {'l', static_cast<std::uint64_t>(l)}; }

  void apply(const Delta& delta) {
    const UpdateReport report = smoother_.update(delta);
    ASSERT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    flips_ += report.flips;
    for (std::size_t i = 1; i < report.objectives.size(); ++i) {
      EXPECT_LE(report.objectives[i], report.objectives[i - 1] +
                                          1e-9 * std::max(1.0, std::abs(report.objectives[i - 1])));
    }
    const double fresh = objective(smoother_.graph(), smoother_.values(), smoother_.assignment());
    EXPECT_NEAR(smoother_.objective(), fresh, 1e-9 * std::max(1.0, std::abs(fresh)));
    ASSERT_EQ(report.handles.size(),
              delta.continuous.size() + delta.discrete.size() + delta.hybrid.size());
    // Loops and sightings may go again; odometry, the prior and tables stay.
    const AddedHandles& added = report.handles;
    removable_.insert(removable_.end(), added.continuous.begin() + 1, added.continuous.end());
    removable_.insert(removable_.end(), added.hybrid.begin(), added.hybrid.end());
  }

  void add_pose(Delta& delta) {
    const int k = static_cast<int>(truth_.size());
    const Pose motion = step_forward<Pose>(0.4);
    const Pose measured = motion * random_.template value<Pose>(0.03);
    truth_.push_back(truth_.back() * motion);
    newest_ = smoother_.values().template at<Pose>(pose(k - 1)) * measured;
    delta.values.insert(pose(k), newest_);
    delta.continuous.push_back(
        std::make_shared<Between<Pose>>(pose(k - 1), pose(k), measured, noise(Pose::kDim)));
  }

  void see_landmark(Delta& delta) {
    const int l = random_.below(static_cast<int>(landmarks_.size()));
    const int k = static_cast<int>(truth_.size()) - 1;
    const BearingRange<Pose> exact(pose(k), landmark(l), Point::Ones(), noise(kPoint));
    Point z = exact.predict(truth_.back(), landmarks_[l]);
    // A landmark that goes in this change cannot come back in it.
    if (z[0] < 0.5 || !delta.remove_values.empty()) return;
    for (int i = 0; i < kPoint; ++i) z[i] += random_.normal(0.02);
    if (!smoother_.values().contains(landmark(l))) {
      delta.values.insert(landmark(l), Point(newest_ * from_polar(z)));
    }
    if (random_.below(2) == 0) {
      delta.continuous.push_back(
          std::make_shared<BearingRange<Pose>>(pose(k), landmark(l), z, noise(kPoint)));
      return;
    }
    const DiscreteKey species{Key('s', l), 3};
    const double u = random_.uniform(0.1, 1.0);
    delta.hybrid.push_back(make_semantic_bearing_range<Pose>(
        pose(k), landmark(l), species, z, noise(kPoint), {u, random_.uniform(0.1, 1.0), 0.4}));
  }

  void close_loop(Delta& delta) {
    const int k = static_cast<int>(truth_.size()) - 1;
    if (k < 4) return;
    const int old = random_.below(k - 2);
    Pose z = truth_[old].between(truth_[k]) * random_.template value<Pose>(0.03);
    const bool untrusted = random_.below(3) != 0;
    if (untrusted && random_.below(3) == 0) {
      z = z * random_.template value<Pose>(random_.below(2) != 0 ? 2.0 : 0.15);
    }
    const auto inlier = std::make_shared<Between<Pose>>(pose(old), pose(k), z, noise(Pose::kDim));
    const DiscreteKey key{Key('d', k), 2};
    if (untrusted) {
      const Noise wide = noise(Pose::kDim).inflated(1e7);
      delta.hybrid.push_back(make_outlier_mixture(
          key, inlier, std::make_shared<Between<Pose>>(pose(old), pose(k), z, wide), 0.5, 0.5));
    } else {  // two measurements of which one is true
      const Pose other = z * random_.template value<Pose>(0.3);
      const auto lie =
          std::make_shared<Between<Pose>>(pose(old), pose(k), other, noise(Pose::kDim));
      delta.hybrid.push_back(std::make_shared<Mixture>(
          std::vector<DiscreteKey>{key},
          std::vector<MixtureComponent>{{inlier, 0.7, false}, {lie, 0.7, false}}));
    }
    delta.assignment.set(key.key, random_.below(2));
    if (random_.below(2) == 0) {
      delta.discrete.push_back(prior_table(key, {random_.uniform(0.2, 1.0), 0.5}));
    }
    const Key before('d', k - 1);
    if (smoother_.assignment().contains(before)) {
      delta.discrete.push_back(transition_table({before, 2}, key, {0.7, 0.3, 0.4, 0.6}));
    }
  }

  void remove_some(Delta& delta) {
    if (removable_.empty() || random_.below(3) != 0) return;
    const int at = random_.below(static_cast<int>(removable_.size()));
    const Handle handle = removable_[at];
    removable_.erase(removable_.begin() + at);
    delta.remove.push_back(handle);
    const HybridGraph& graph = smoother_.graph();
    const std::vector<Key>& keys = handle.kind == FactorKind::kHybrid
                                       ? graph.hybrid().at(handle)->keys()
                                       : graph.continuous().at(handle)->keys();
    // A landmark goes with its last sighting.
    if (keys[1].letter() == 'l' && smoother_.factors_of(keys[1]).size() == 1) {
      delta.remove_values.push_back(keys[1]);
    }
  }

  Random random_;
  IncrementalSmoother smoother_;
  std::vector<Pose> truth_;
  std::vector<Point> landmarks_;
  std::vector<Handle> removable_;
  Pose newest_;
  int flips_ = 0;
  int equal_ = 0;
};

template <class Pose>
void run(int graphs, int steps) {
  int flips = 0;
  int equal = 0;
  for (int seed = 1; seed <= graphs; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    World<Pose> world(seed);
    for (int k = 0; k < steps; ++k) {
      world.step();
      if (::testing::Test::HasFailure()) return;
    }
    world.expect_equals_batch();
    if (::testing::Test::HasFailure()) return;
    flips += world.flips();
    equal += world.equal();
  }
  EXPECT_GT(flips, graphs);
  // The two may end in different modes, but seldom do.
  EXPECT_GE(equal, graphs * 9 / 10);
}

TEST(RandomGraphs, PlanarIncrementalEqualsBatch) {
  run<SE2>(cases(150), 35);
}

TEST(RandomGraphs, SpatialIncrementalEqualsBatch) {
  run<SE3>(cases(60), 25);
}

}  // namespace
}  // namespace hybrid
