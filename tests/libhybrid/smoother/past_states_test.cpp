// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// States that have left a bounded window, after a loop is closed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "tests/support/bounded_walk.h"

namespace hybrid {
namespace {

using testing::bounded;

Key pose_key(int i) {
  return {'x', static_cast<std::uint64_t>(i)};
}

/// A road that comes back after some steps, past landmarks on both sides, each seen for a while,
/// with odometry that turns too little.
template <class Pose>
class RoundRoad {
 public:
  using Point = typename Pose::Point;
  static constexpr int kSteps = 200, kSpacing = 5, kAgain = 20;

  /// The change of step t, given the estimate so far.
  Delta step(int t, const Values& estimate) {
    Delta delta;
    Pose start = truth(0);
    if (t == 0) {
      delta.continuous.push_back(
          std::make_shared<Prior<Pose>>(pose_key(0), start, Noise::isotropic(Pose::kDim, 1e-3)));
    } else {
      typename Pose::Tangent bias = Pose::Tangent::Zero();
      bias[Pose::kDim - 1] = -0.01;
      const Pose z = truth(t - 1).between(truth(t)) * Pose::exp(bias);
      delta.continuous.push_back(std::make_shared<Between<Pose>>(
          pose_key(t - 1), pose_key(t), z, Noise::isotropic(Pose::kDim, 0.02)));
      start = estimate.at<Pose>(pose_key(t - 1)) * z;
    }
    delta.values.insert(pose_key(t), start);
    for (int k = t - 8; k <= t + 8; ++k) {
      const int landmark = (k + kSteps) % kSteps;
      if (landmark % kSpacing == 0) see(t, landmark, start, delta);
    }
    return delta;
  }

 private:
  static Pose truth(int t) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.rotate(Eigen::AngleAxisd(2 * M_PI * t / kSteps, Eigen::Vector3d::UnitZ()));
    pose.translate(Eigen::Vector3d(0, -50, 0));
    Values values;
    insert_pose(values, pose_key(0), pose, Pose::kDim == 6);
    return values.at<Pose>(pose_key(0));
  }
  void see(int t, int landmark, const Pose& start, Delta& delta) {
    Point beside = Point::Zero();
    beside[1] = landmark % (2 * kSpacing) == 0 ? 4 : -4;
    const Point z = to_polar(Point(truth(t).inverse() * (truth(landmark) * beside)));
    const Key key('l', static_cast<std::uint64_t>(landmark));
    if (seen_.insert(landmark).second) delta.values.insert(key, Point(start * from_polar(z)));
    delta.continuous.push_back(std::make_shared<BearingRange<Pose>>(
        pose_key(t), key, z, Noise::isotropic(Point::RowsAtCompileTime, 0.02)));
  }

  std::set<int> seen_;
};

template <class Pose>
void expect_moved_along() {
  WindowSmoother window(bounded(20, 2));
  IncrementalSmoother full;
  RoundRoad<Pose> first, second;
  for (int t = 0; t < RoundRoad<Pose>::kSteps + RoundRoad<Pose>::kAgain; ++t) {
    ASSERT_EQ(window.update(first.step(t, window.smoother().values())).status,
              UpdateReport::Status::kOk);
    full.update(second.step(t, full.values()));
  }
  window.converge();
  full.converge();
  const Values past = window.past_states();
  ASSERT_GE(past.keys().size(), 50U);
  double as_it_left = 0, moved_along = 0;
  for (const Key key : past.keys()) {
    const auto is = full.values().at<Pose>(key);
    const auto off = [&](const Values& v) { return is.between(v.at<Pose>(key)).log().norm(); };
    as_it_left = std::max(as_it_left, off(window.past().values));
    moved_along = std::max(moved_along, off(past));
  }
  EXPECT_GT(as_it_left, 0.5);
  EXPECT_LT(moved_along, 0.05 * as_it_left);
}

/// What is told of the path is whole after every update: no step differs from odometry by more than
/// in the estimate of all, and by little from what is told at the end.
template <class Pose>
void expect_whole_at_every_moment() {
  WindowSmoother window(bounded(20, 2));
  RoundRoad<Pose> road;
  Values told;
  double apart = 0;
  for (int t = 0; t < RoundRoad<Pose>::kSteps + RoundRoad<Pose>::kAgain; ++t) {
    const WindowReport report = window.update(road.step(t, window.smoother().values()));
    ASSERT_EQ(report.status, UpdateReport::Status::kOk);
    const auto put = [&](Key key, const Values& from) {
      if (told.contains(key)) told.erase(key);
      told.insert(key, from.type(key), from.data(key));
    };
    for (const Key key : report.left) put(key, window.past().values);
    const Values moved = window.moved_past_states(report.changed);
    for (const Key key : moved.keys()) put(key, moved);
    const Values exact = window.past_states();
    for (const Key key : exact.keys()) {
      const auto off = told.at<Pose>(key).between(exact.at<Pose>(key)).log();
      apart = std::max(apart, off.norm());
    }
  }
  ASSERT_GE(told.size(), 50U);
  EXPECT_LT(apart, 0.1);  // [m, rad]
}

TEST(PastStates, AreWholeAtEveryMomentInThePlane) {
  expect_whole_at_every_moment<SE2>();
}

TEST(PastStates, AreWholeAtEveryMomentInSpace) {
  expect_whole_at_every_moment<SE3>();
}

TEST(PastStates, MoveAlongInThePlaneWhenALoopCloses) {
  expect_moved_along<SE2>();
}

TEST(PastStates, MoveAlongInSpaceWhenALoopCloses) {
  expect_moved_along<SE3>();
}

// Of many states that hang on one landmark, one is held far better than the others: it alone
// follows each of its small motions, and the others once these come to what matters for them.
TEST(PastStates, EachFollowsByItsOwnStep) {
  constexpr int kStates = 1000, kMotions = 100;
  constexpr double kStep = 0.01;  // m, of the others
  PastStates past;
  const Key landmark('l', 0);
  Values window;
  window.insert(landmark, Eigen::Vector2d(3, 4));
  for (int i = 0; i < kStates; ++i) {
    PastStates::Departure departure;
    departure.states.insert(pose_key(i), SE2(i, 0, 0));
    departure.tied = window;
    departure.step = i == 0 ? 1e-6 : kStep;
    past.leave(std::move(departure));
  }
  std::size_t told = 0;
  for (int k = 0; k < kMotions; ++k) {
    window.update(landmark, Eigen::Vector2d(3 + 1.5 * kStep * (k + 1) / kMotions, 4));
    while (const std::size_t now = past.follow(window, {landmark}, {}).size()) told += now;
  }
  EXPECT_GE(told, std::size_t{kMotions + kStates - 1});
  EXPECT_LE(told, std::size_t{kMotions + 2 * (kStates - 1)});
}

TEST(PastStates, AreThoseThatHaveLeft) {
  WindowSmoother window(bounded(20, 2));
  RoundRoad<SE2> road;
  for (int t = 0; t < 150; ++t) window.update(road.step(t, window.smoother().values()));
  const Values past = window.past_states();
  EXPECT_GE(past.keys().size(), 10U);
  EXPECT_EQ(past.keys().size(), window.past().values.keys().size());
  for (const Key key : past.keys()) EXPECT_FALSE(window.smoother().values().contains(key));
}

/// The change of step t of a road without landmarks, from a start that is given.
Delta straight_step(int t, const Values& estimate) {
  Delta delta;
  if (t == 0) {
    delta.values.insert(pose_key(0), SE2());
    delta.continuous.push_back(
        std::make_shared<Prior<SE2>>(pose_key(0), SE2(), Noise::isotropic(3, 1e-6)));
  } else {
    const SE2 step(1, 0, 0);
    delta.values.insert(pose_key(t), estimate.at<SE2>(pose_key(t - 1)) * step);
    delta.continuous.push_back(std::make_shared<BetweenSE2>(
        pose_key(t - 1), pose_key(t), step, Noise::diagonal(Eigen::Vector3d(0.1, 0.1, 0.01))));
  }
  return delta;
}

// What is tied to one pose alone moves with it as far as the start allows.
TEST(PastStates, HangBetweenAGivenStartAndWhatHasMoved) {
  WindowSmoother window(bounded(60, 5));
  IncrementalSmoother full;
  for (int t = 0; t < 130; ++t) {
    window.update(straight_step(t, window.smoother().values()));
    full.update(straight_step(t, full.values()));
  }
  Delta found;
  found.continuous.push_back(
      std::make_shared<Prior<SE2>>(pose_key(129), SE2(129, 5, 0.05), Noise::isotropic(3, 1e-3)));
  window.update(found);
  full.update(found);
  window.converge();
  full.converge();
  const Values past = window.past_states();
  ASSERT_GE(past.keys().size(), 100U);
  for (const Key key : past.keys()) {
    const SE2 error = full.values().at<SE2>(key).between(past.at<SE2>(key));
    EXPECT_LT(error.log().norm(), 0.05) << to_string(key);
  }
  EXPECT_LT(past.at<SE2>(pose_key(0)).log().norm(), 1e-5);
}

}  // namespace
}  // namespace hybrid
