// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// The end of a long way, whose place is known poorly and whose surroundings are known well.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <memory>
#include <random>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/sensor_view.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/smoother/incremental.h"

namespace hybrid {
namespace {

/// A road past landmarks on both sides, each of which is seen for a while.
template <class Pose>
class Road {
 public:
  using Point = typename Pose::Point;
  static constexpr int kPoint = Point::RowsAtCompileTime, kSpacing = 5, kReach = 8;

  /// `sigma` is that of the first pose, in m and rad.
  explicit Road(double sigma) : sigma_(sigma) {}

  static Key pose(int t) { return {'x', static_cast<std::uint64_t>(t)}; }
  static Key landmark(int k) { return {'l', static_cast<std::uint64_t>(k)}; }
  static Point place(int k) {
    Point p = Point::Zero();
    p[0] = 2.0 * k;
    p[1] = k % (2 * kSpacing) == 0 ? 4 : -4;
    return p;
  }

  /// The change of step t, given the estimate so far.
  Delta step(int t, const Values& estimate) {
    Delta delta;
    Pose start;
    if (t == 0) {
      delta.continuous.push_back(
          std::make_shared<Prior<Pose>>(pose(0), start, Noise::isotropic(Pose::kDim, sigma_)));
    } else {
      const Pose z = truth(t - 1).between(truth(t)) * Pose::exp(noise<Pose::kDim>(0.01));
      delta.continuous.push_back(std::make_shared<Between<Pose>>(
          pose(t - 1), pose(t), z, Noise::isotropic(Pose::kDim, 0.01)));
      start = estimate.at<Pose>(pose(t - 1)) * z;
    }
    delta.values.insert(pose(t), start);
    for (int k = t - kReach; k <= t + kReach; ++k) {
      if (k < 0 || k % kSpacing != 0) continue;
      const Point z = to_polar(Point(truth(t).inverse() * place(k))) + noise<kPoint>(0.02);
      if (k > seen_) {
        seen_ = k;
        delta.values.insert(landmark(k), Point(start * from_polar(z)));
      }
      delta.continuous.push_back(std::make_shared<BearingRange<Pose>>(
          pose(t), landmark(k), z, Noise::isotropic(kPoint, 0.02)));
    }
    return delta;
  }

 private:
  static Pose truth(int t) {
    typename Pose::Tangent way = Pose::Tangent::Zero();
    way[0] = 2.0 * t;
    return Pose::exp(way);
  }
  template <int N>
  Eigen::Matrix<double, N, 1> noise(double sigma) {
    Eigen::Matrix<double, N, 1> out;
    for (double& x : out) x = sigma * std::normal_distribution<double>()(random_);
    return out;
  }

  double sigma_;
  std::mt19937 random_{5};
  int seen_ = -1;
};

/// What is measured at the end of the road says nothing about its beginning. Steps that stop where
/// little is to be gained used to leave a kink there, and all behind it swung.
TEST(LongWay, WhatIsMeasuredAtItsEndMovesNothingFarBack) {
  constexpr int kSteps = 600, kLast = 40, kFar = 300;
  Road<SE2> road(1e-3);
  IncrementalSmoother smoother;
  for (int t = 0; t < kSteps; ++t) {
    ASSERT_EQ(smoother.update(road.step(t, smoother.values())).status, UpdateReport::Status::kOk);
  }
  smoother.converge();
  double moved = 0;
  std::size_t most = 0;
  for (int t = kSteps; t < kSteps + kLast; ++t) {
    const Values before = smoother.values();
    const UpdateReport report = smoother.update(road.step(t, before));
    most = std::max(most, report.changed.size());
    for (int far = 0; far < kFar; ++far) {
      const Key key = Road<SE2>::pose(far);
      moved =
          std::max(moved, before.at<SE2>(key).between(smoother.values().at<SE2>(key)).log().norm());
    }
  }
  EXPECT_LT(moved, 1e-6);
  EXPECT_LT(most, 150U);  // of some 900 variables
}

/// The covariance of the sightings of landmarks to expect from a pose.
template <class Pose>
Eigen::MatrixXd predicted(const IncrementalSmoother& smoother, int t, int first, int last) {
  constexpr int kPoint = Road<Pose>::kPoint;
  std::vector<Key> keys{Road<Pose>::pose(t)};
  for (int k = first; k <= last; k += Road<Pose>::kSpacing) {
    keys.push_back(Road<Pose>::landmark(k));
  }
  const auto n = static_cast<Eigen::Index>(keys.size()) - 1;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(kPoint * n, Pose::kDim + kPoint * n);
  const SensorView<Pose> view{Pose()};
  for (Eigen::Index k = 0; k < n; ++k) {
    typename SensorView<Pose>::PoseMatrix by_pose;
    typename SensorView<Pose>::Matrix by_point;
    view.polar(smoother.values().template at<Pose>(keys[0]),
               smoother.values().template at<typename Pose::Point>(keys[k + 1]), &by_pose,
               &by_point);
    J.block<kPoint, Pose::kDim>(kPoint * k, 0) = by_pose;
    J.block<kPoint, kPoint>(kPoint * k, Pose::kDim + kPoint * k) = by_point;
  }
  return smoother.joint_covariance(keys, J);
}

/// What is seen of landmarks from a pose beside them does not depend on how well the place of both
/// is known; not either where the estimate has moved since it was linearised.
template <class Pose>
void expect_local() {
  constexpr int kSteps = 60;
  SmootherOptions options;
  options.relinearize = 0.1;
  IncrementalSmoother known(options), lost(options);
  Road<Pose> of_known(1e-3), of_lost(100);
  for (int t = 0; t < kSteps; ++t) {
    known.update(of_known.step(t, known.values()));
    lost.update(of_lost.step(t, lost.values()));
    if (t < 20) continue;
    const Eigen::MatrixXd exact = predicted<Pose>(known, t, (t / 5 - 1) * 5, (t / 5 + 1) * 5);
    const Eigen::MatrixXd found = predicted<Pose>(lost, t, (t / 5 - 1) * 5, (t / 5 + 1) * 5);
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> ratio(found, exact);
    EXPECT_GT(ratio.eigenvalues().minCoeff(), 0.8) << t;
    EXPECT_LT(ratio.eigenvalues().maxCoeff(), 1.25) << t;
  }
}

TEST(LongWay, SightingsInThePlaneArePredictedAsWellAsNearby) {
  expect_local<SE2>();
}

TEST(LongWay, SightingsInSpaceArePredictedAsWellAsNearby) {
  expect_local<SE3>();
}

/// settle() leaves a hundredth of what updates leave: nearly all of what convergence brings.
TEST(LongWay, SettlesNearlyAsFarAsItConverges) {
  Road<SE2> road(1e-3);
  SmootherOptions options;
  options.relinearize = 0.1;
  options.wildfire = 0.1;
  IncrementalSmoother smoother(options);
  for (int t = 0; t < 100; ++t) smoother.update(road.step(t, smoother.values()));
  // A landmark of the middle is measured again, far off where it was.
  Delta delta;
  delta.continuous.push_back(std::make_shared<Prior<Eigen::Vector2d>>(
      Road<SE2>::landmark(100), Eigen::Vector2d(220, 60), Noise::isotropic(2, 0.5)));
  smoother.update(delta);
  IncrementalSmoother converged = smoother;
  converged.converge();
  const double open = smoother.objective() - converged.objective();
  const UpdateReport report = smoother.settle();
  EXPECT_EQ(report.status, UpdateReport::Status::kOk);
  EXPECT_DOUBLE_EQ(report.objective_after, smoother.objective());
  EXPECT_TRUE(std::is_sorted(report.objectives.rbegin(), report.objectives.rend()));
  EXPECT_GT(open, 1e-2);
  EXPECT_LT(smoother.objective() - converged.objective(), 0.1 * open);
}

/// Whoever copies what is said to have changed has the estimate.
TEST(LongWay, WhatChangedIsSaid) {
  Road<SE2> road(1e-3);
  IncrementalSmoother smoother;
  Values copy;
  for (int t = 0; t < 100; ++t) {
    const UpdateReport report = smoother.update(road.step(t, smoother.values()));
    for (const Key key : report.changed) {
      if (copy.contains(key)) copy.erase(key);
      copy.insert(key, smoother.values().type(key), smoother.values().data(key));
    }
    for (const Key key : smoother.values().keys()) {
      ASSERT_TRUE(copy.contains(key)) << t;
      const double* x = smoother.values().data(key);
      ASSERT_TRUE(std::equal(x, x + smoother.values().type(key).size, copy.data(key))) << t;
    }
  }
}

}  // namespace
}  // namespace hybrid
