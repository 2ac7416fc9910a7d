// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// One meaning of a covariance: the inverse of the Hessian of all chosen components (eq. 13), weak
// ones included, from every way to it.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <memory>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/range.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/smoother/window.h"
#include "tests/support/dense_graph.h"
#include "tests/support/random.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::pose;
using testing::Random;
using Vector1 = Eigen::Matrix<double, 1, 1>;

/// The largest entry of the difference of two covariances, in units of the standard deviations.
double difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& exact) {
  const Eigen::VectorXd scale = exact.diagonal().cwiseSqrt().cwiseInverse();
  return (scale.asDiagonal() * (a - exact) * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

ContinuousFactorPtr offset(Key a, Key b, double z, double sigma) {
  class Offset : public FactorOf<1, Vector1, Vector1> {
   public:
    Offset(Key from, Key to, double measured, double noise)
        : FactorOf({from, to}, Noise::isotropic(1, noise)), z_(measured) {}
    std::string name() const override { return "offset"; }
    Residual evaluate(const Vector1& from, const Vector1& to, Jacobian<Vector1>* Ja,
                      Jacobian<Vector1>* Jb) const override {
      if (Ja != nullptr) (*Ja)(0) = -1.0;
      if (Jb != nullptr) (*Jb)(0) = 1.0;
      return to - from - Vector1(z_);
    }

   private:
    double z_;
  };
  return std::make_shared<Offset>(a, b, z, sigma);
}

/// Two scalars with priors, and a link between them in its outlier mode.
Delta two_scalars(double inflation, double inlier_weight) {
  Delta delta;
  delta.values.insert(pose(0), Vector1(0.0));
  delta.values.insert(pose(1), Vector1(30.0));
  delta.continuous.push_back(
      std::make_shared<Prior<Vector1>>(pose(0), Vector1(0.0), Noise::unit(1)));
  delta.continuous.push_back(
      std::make_shared<Prior<Vector1>>(pose(1), Vector1(30.0), Noise::isotropic(1, 10.0)));
  delta.hybrid.push_back(make_outlier_mixture({Key('d', 0), 2}, offset(pose(0), pose(1), 10.0, 1.0),
                                              offset(pose(0), pose(1), 10.0, std::sqrt(inflation)),
                                              inlier_weight, 1.0 - inlier_weight));
  delta.assignment.set(Key('d', 0), 1);
  return delta;
}

TEST(Covariance, CountsTheOutlierModelThatIsChosen) {
  for (const double inflation : {10.0, 100.0, 1e4, 1e8}) {
    IncrementalSmoother smoother;
    ASSERT_EQ(smoother.update(two_scalars(inflation, 1e-12)).status, UpdateReport::Status::kOk);
    ASSERT_EQ(smoother.assignment().at(Key('d', 0)), 1);
    const double exact = 1.0 / (0.01 + 1.0 / (1.0 + inflation));
    const Estimate estimate = smoother.estimate();
    EXPECT_NEAR(ContinuousMarginals(smoother.graph(), estimate).covariance(pose(1))(0, 0), exact,
                1e-9 * exact);
    EXPECT_NEAR(smoother.joint_covariance({pose(1)})(0, 0), exact, 1e-9 * exact);
    smoother.converge();
    EXPECT_NEAR(smoother.joint_covariance({pose(1)})(0, 0), exact, 1e-9 * exact);
  }
}

/// A random hybrid graph: odometry, loops that are mixtures with outlier models of all widths in
/// either mode, landmarks seen through mixtures of their own.
Delta random_delta(int seed) {
  Random random(seed);
  const auto s = testing::simulate_loops<SE2, BetweenSE2>(14, 3, 0.05, seed);
  Delta delta;
  delta.values = s.initial.values;
  s.graph.continuous().for_each([&](Handle, const auto& f) { delta.continuous.push_back(f); });
  int switches = 0;
  const auto add = [&](ContinuousFactorPtr inlier, ContinuousFactorPtr outlier) {
    const DiscreteKey key{Key('d', switches++), 2};
    const double weight = random.below(2) == 0 ? 1e-30 : 0.5;  // of the inlier
    delta.hybrid.push_back(
        make_outlier_mixture(key, std::move(inlier), std::move(outlier), weight, 1.0 - weight));
    delta.assignment.set(key.key, weight < 0.5 ? 1 : 0);
  };
  for (int k = 0; k < 8; ++k) {
    const Key a = pose(random.below(7)), b = pose(7 + random.below(7));
    const SE2 z = s.truth.at<SE2>(a).between(s.truth.at<SE2>(b)) * random.value<SE2>(0.05);
    const Noise noise = Noise::isotropic(3, 0.05);
    add(std::make_shared<BetweenSE2>(a, b, z, noise),
        std::make_shared<BetweenSE2>(a, b, z, noise.inflated(std::pow(10.0, random.below(9)))));
  }
  for (int l = 0; l < 3; ++l) {
    const Eigen::Vector2d at = s.truth.at<SE2>(pose(4 * l)) * Eigen::Vector2d(3.0, 1.0);
    delta.values.insert(Key('l', l), at);
    for (int i = 4 * l; i < 4 * l + 3; ++i) {
      const Eigen::Vector2d seen = s.truth.at<SE2>(pose(i)).inverse() * at;
      const Eigen::Vector2d z(seen.norm(), std::atan2(seen[1], seen[0]));
      const Noise noise = Noise::isotropic(2, 0.05);
      add(std::make_shared<BearingRange2>(pose(i), Key('l', l), z, noise),
          std::make_shared<BearingRange2>(pose(i), Key('l', l), z,
                                          noise.inflated(l == 2 ? 1e7 : 100.0)));
    }
  }
  return delta;
}

TEST(Covariance, OfEveryBackEndIsTheDenseInverseOnRandomHybridGraphs) {
  int weak = 0;
  for (int seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    WindowSmoother window;
    ASSERT_EQ(window.update(random_delta(seed)).status, UpdateReport::Status::kOk);
    window.converge(100, 1e-15);  // linearised where the estimate is
    const IncrementalSmoother& smoother = window.smoother();
    const Estimate estimate = smoother.estimate();
    smoother.graph().hybrid().for_each([&](Handle, const auto& factor) {
      weak += factor->given(estimate.assignment).weak ? 1 : 0;
    });
    const std::vector<Key> keys = estimate.values.keys();
    const Eigen::MatrixXd exact = testing::dense_information(smoother.graph(), estimate).inverse();
    EXPECT_LT(difference(smoother.joint_covariance(keys), exact), 1e-5);
    const ContinuousMarginals marginals(smoother.graph(), estimate);
    EXPECT_LT(difference(marginals.joint_covariance(keys), exact), 1e-7);
    const Covariances all = marginals.all();
    std::size_t visited = 0;
    int start = 0;
    std::unordered_map<Key, Eigen::MatrixXd> blocks;
    for (Key key : keys) {
      const int dim = estimate.values.type(key).dim;
      blocks[key] = exact.block(start, start, dim, dim);
      EXPECT_LT(difference(all.at(key), blocks[key]), 1e-7);
      start += dim;
    }
    smoother.visit_covariances([&](Key key, const Eigen::MatrixXd& covariance) {
      EXPECT_LT(difference(covariance, blocks.at(key)), 1e-5);
      ++visited;
    });
    EXPECT_EQ(visited, keys.size());
  }
  EXPECT_GT(weak, 60);
}

// A variable that nothing but a weak component holds is known as well as that says.
TEST(Covariance, OfAVariableThatHangsOnAWeakComponent) {
  IncrementalSmoother smoother;
  Delta delta = two_scalars(1e8, 1e-12);
  delta.continuous.pop_back();
  ASSERT_EQ(smoother.update(delta).status, UpdateReport::Status::kOk);
  EXPECT_NEAR(smoother.joint_covariance({pose(1)})(0, 0), 1.0 + 1e8, 1e-6 * 1e8);
  // It enters when what held the variable goes, too, and what is singular for other reasons is
  // refused as ever.
  IncrementalSmoother second;
  const UpdateReport report = second.update(two_scalars(1e8, 1e-12));
  Delta free;
  free.values.insert(pose(2), Vector1(0.0));
  EXPECT_EQ(second.update(free).status, UpdateReport::Status::kSingular);
  Delta removal;
  removal.remove = {report.handles.continuous[1]};
  ASSERT_EQ(second.update(removal).status, UpdateReport::Status::kOk);
  EXPECT_NEAR(second.joint_covariance({pose(1)})(0, 0), 1.0 + 1e8, 1e-6 * 1e8);
  second.converge();
  EXPECT_NEAR(second.values().at<Vector1>(pose(1))[0], 10.0, 1e-6);
}

// The estimate of an update may be turned from where it was linearised.
TEST(Covariance, IsOneBeforeConvergenceToo) {
  IncrementalSmoother smoother;
  const Noise noise = Noise::diagonal(Eigen::Vector3d(0.05, 0.02, 0.01));
  for (int i = 0; i < 30; ++i) {
    Delta delta;
    const SE2 step(1, 0, 0.05);
    if (i == 0) {
      delta.values.insert(pose(0), SE2());
      delta.continuous.push_back(std::make_shared<Prior<SE2>>(
          pose(0), SE2(), Noise::diagonal(Eigen::Vector3d(0.1, 0.3, 1.0))));
    } else {
      delta.values.insert(pose(i), smoother.values().at<SE2>(pose(i - 1)) * step);
      delta.continuous.push_back(std::make_shared<BetweenSE2>(pose(i - 1), pose(i), step, noise));
    }
    smoother.update(delta);
  }
  const SE2 last = smoother.values().at<SE2>(pose(29));
  Delta compass;
  compass.continuous.push_back(
      std::make_shared<Prior<SE2>>(pose(29), SE2(last.x(), last.y(), last.angle() + 1.2),
                                   Noise::diagonal(Eigen::Vector3d(1e4, 1e4, 0.3))));
  smoother.update(compass);
  const std::vector<Key> keys = {pose(0), pose(10), pose(29)};
  const Eigen::MatrixXd all = smoother.joint_covariance(keys, Eigen::MatrixXd::Identity(9, 9));
  EXPECT_LT(difference(smoother.joint_covariance(keys), all), 1e-9);
  smoother.visit_covariances([&](Key key, const Eigen::MatrixXd& covariance) {
    const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(3, 3);
    EXPECT_LT(difference(covariance, smoother.joint_covariance({key}, I)), 1e-9) << to_string(key);
  });
}

// How much an update leaves open tells that they may differ.
TEST(Covariance, IsThatOfTheBatchWhereLittleIsOpen) {
  IncrementalSmoother smoother;
  Delta known, ranges;
  const Key thing('l', 0);
  ranges.values.insert(thing, Eigen::Vector2d(-2, -1));
  for (int i = 0; i < 3; ++i) {
    const SE2 at(3.0 * i, i == 1 ? 2.0 : 0.0, 0.0);
    known.values.insert(pose(i), at);
    known.continuous.push_back(
        std::make_shared<Prior<SE2>>(pose(i), at, Noise::isotropic(3, 0.01)));
    const double range = Eigen::Vector2d(Eigen::Vector2d(3, 6) - at.translation()).norm();
    ranges.continuous.push_back(std::make_shared<Range<SE2, Eigen::Vector2d>>(
        pose(i), thing, range, Noise::isotropic(1, 0.05)));
  }
  smoother.update(known);
  const auto off_batch = [&] {
    const ContinuousMarginals batch(smoother.graph(), smoother.estimate());
    return difference(smoother.joint_covariance({thing}), batch.covariance(thing));
  };
  EXPECT_GT(smoother.update(ranges).open, 0.04);
  EXPECT_GT(off_batch(), 0.1);
  EXPECT_LT(smoother.converge().open, 0.04);
  EXPECT_LT(off_batch(), 0.01);
}

/// The landmarks of a walk in a circle past them, turned by half a radian when a compass
/// comes in at the end: most of the map has moved since it was linearised.
template <class Pose>
std::vector<Key> walk(IncrementalSmoother& smoother, const Pose& step, const Pose& turned) {
  using Point = typename Pose::Point;
  constexpr int kDim = Pose::kDim, kPointDim = Point::RowsAtCompileTime;
  Random random(3);
  std::vector<Pose> truth;
  std::vector<Key> landmarks;
  std::vector<Point> places;
  for (int i = 0; i < 25; ++i) {
    Delta delta;
    truth.push_back(i == 0 ? Pose() : truth.back() * step);
    if (i == 0) {
      delta.values.insert(pose(0), truth[0]);
      delta.continuous.push_back(
          std::make_shared<Prior<Pose>>(pose(0), truth[0], Noise::isotropic(kDim, 0.3)));
    } else {
      delta.values.insert(pose(i), smoother.values().at<Pose>(pose(i - 1)) * step);
      delta.continuous.push_back(std::make_shared<Between<Pose>>(pose(i - 1), pose(i), step,
                                                                 Noise::isotropic(kDim, 0.05)));
    }
    if (i % 3 == 0) {
      places.push_back(truth[i] * Point(Point::Constant(2.0 + random.uniform())));
      landmarks.push_back(Key('l', i));
      delta.values.insert(landmarks.back(), places.back());
    }
    for (std::size_t l = landmarks.size() > 3 ? landmarks.size() - 3 : 0; l < landmarks.size();
         ++l) {
      delta.continuous.push_back(std::make_shared<BearingRange<Pose>>(
          pose(i), landmarks[l], to_polar(Point(truth[i].inverse() * places[l])),
          Noise::isotropic(kPointDim, 0.02)));
    }
    EXPECT_EQ(smoother.update(delta).status, UpdateReport::Status::kOk);
  }
  Delta compass;
  compass.continuous.push_back(
      std::make_shared<Prior<Pose>>(pose(0), turned, Noise::isotropic(kDim, 0.01)));
  EXPECT_EQ(smoother.update(compass).status, UpdateReport::Status::kOk);
  return landmarks;
}

template <class Pose>
void expect_one_covariance(const Pose& step, const Pose& turned) {
  constexpr int kDim = Pose::kDim, kPointDim = Pose::Point::RowsAtCompileTime;
  IncrementalSmoother smoother;
  const std::vector<Key> landmarks = walk(smoother, step, turned);
  smoother.visit_covariances([&](Key key, const Eigen::MatrixXd& covariance) {
    EXPECT_LT(difference(covariance, smoother.joint_covariance({key})), 1e-9) << to_string(key);
  });
  // Landmarks as they are seen from a pose, asked at once and one by one.
  std::vector<Key> keys = landmarks;
  keys.insert(keys.begin(), pose(12));
  const auto dims = static_cast<Eigen::Index>(kPointDim * landmarks.size());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(dims, kDim + dims);
  const Pose from = smoother.values().at<Pose>(pose(12));
  const Eigen::MatrixXd back = from.rotation().matrix().transpose();
  for (std::size_t l = 0; l < landmarks.size(); ++l) {
    const auto row = static_cast<Eigen::Index>(kPointDim * l);
    J.block(row, 0, kPointDim, kPointDim) = -Eigen::MatrixXd::Identity(kPointDim, kPointDim);
    J.block(row, kDim + row, kPointDim, kPointDim) = back;
  }
  const Eigen::MatrixXd at_once = smoother.joint_covariance(keys, J);
  EXPECT_LT(difference(at_once, J * smoother.joint_covariance(keys) * J.transpose()), 1e-9);
  for (std::size_t l = 0; l < landmarks.size(); ++l) {
    const auto row = static_cast<Eigen::Index>(kPointDim * l);
    Eigen::MatrixXd own(kPointDim, kDim + kPointDim);
    own << J.block(row, 0, kPointDim, kDim), back;
    EXPECT_LT(difference(at_once.block(row, row, kPointDim, kPointDim),
                         smoother.joint_covariance({pose(12), landmarks[l]}, own)),
              1e-9);
  }
}

TEST(Covariance, OfAMapOfLandmarksThatHasMovedIsOne) {
  expect_one_covariance<SE2>(SE2(1.0, 0.0, 0.2), SE2(0.3, 0.1, 0.5));
  expect_one_covariance<SE3>(
      SE3(Eigen::Vector3d(1.0, 0.0, 0.05), SO3::exp(Eigen::Vector3d(0.02, 0.01, 0.2))),
      SE3(Eigen::Vector3d(0.3, 0.1, 0.0), SO3::exp(Eigen::Vector3d(0.1, -0.2, 0.5))));
}

}  // namespace
}  // namespace hybrid
