// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Manifolds of users are variables like those of the library: in values, factors, solvers,
// marginals and windows.
#include "tests/support/user_variables.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <memory>

#include "libhybrid/factors/auto_diff_factor.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/expect_jacobians.h"
#include "libhybrid/factors/linear_factor.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/smoother/window.h"
#include "libhybrid/solvers/alternating.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;
using testing::S2;
using testing::Sim3;

template <class T>
T any(Random& random) {
  if constexpr (std::is_same_v<T, double>) {
    return random.normal();
  } else {
    typename T::Tangent delta;
    for (double& entry : delta) entry = 0.7 * random.normal();
    return T().retract(delta);
  }
}

/// q * p of a quaternion x y z w and a point.
template <class S>
Eigen::Matrix<S, 3, 1> rotated(const Eigen::Matrix<S, 4, 1>& q, const Eigen::Matrix<S, 3, 1>& p) {
  const Eigen::Matrix<S, 3, 1> u = q.template head<3>();
  const Eigen::Matrix<S, 3, 1> t = S(2) * u.cross(p);
  return p + q[3] * t + u.cross(t);
}

/// Where a similarity puts a point, against a measured place.
struct PointThroughSim3 {
  Eigen::Vector3d measured;
  template <class S>
  Eigen::Matrix<S, 3, 1> operator()(const Eigen::Matrix<S, 8, 1>& T,
                                    const Eigen::Matrix<S, 3, 1>& p) const {
    const Eigen::Matrix<S, 4, 1> q = T.template segment<4>(3);
    return T[7] * rotated(q, p) + T.template head<3>() - measured.cast<S>();
  }
};
using PointFactor = AutoDiffFactor<3, PointThroughSim3, Sim3, Eigen::Vector3d>;

/// A direction seen by a rotated sensor.
struct DirectionThroughSO3 {
  Eigen::Vector3d measured;
  template <class S>
  Eigen::Matrix<S, 3, 1> operator()(const Eigen::Matrix<S, 4, 1>& q,
                                    const Eigen::Matrix<S, 3, 1>& v) const {
    return rotated(q, v) - measured.cast<S>();
  }
};
using DirectionFactor = AutoDiffFactor<3, DirectionThroughSO3, SO3, S2>;

template <class T>
class UserVariable : public ::testing::Test {};
using UserTypes = ::testing::Types<Sim3, S2>;
TYPED_TEST_SUITE(UserVariable, UserTypes);

TYPED_TEST(UserVariable, RetractAndLocalAreInverse) {
  using T = TypeParam;
  Random random(1);
  const VariableType type = Variable<T>::type();
  EXPECT_EQ(type.kind, VariableKind::kManifold);
  EXPECT_EQ(to_string(type), T::kName);
  for (int n = 0; n < 50; ++n) {
    Values values;
    values.insert(Key('a', 0), any<T>(random));
    values.insert(Key('a', 1), any<T>(random));
    const double *x = values.data(Key('a', 0)), *y = values.data(Key('a', 1));
    Eigen::VectorXd delta(type.dim), moved(type.size);
    local(type, x, y, delta.data());
    retract(type, x, delta.data(), moved.data());
    local(type, moved.data(), y, delta.data());  // storage may differ in sign, as quaternions do
    EXPECT_LT(delta.norm(), 1e-9);
  }
}

TYPED_TEST(UserVariable, IsOfItsOwnTypeInValues) {
  using T = TypeParam;
  Random random(2);
  Values values;
  values.insert(Key('a', 0), any<T>(random));
  EXPECT_THROW(values.at<SE3>(Key('a', 0)), Error);
  EXPECT_NO_THROW(values.at<T>(Key('a', 0)));
  EXPECT_NE(Variable<Sim3>::type(), Variable<S2>::type());
  EXPECT_NE(Variable<T>::type(), vector_type(T::kDim));
  Eigen::VectorXd bad = Eigen::VectorXd::Constant(T::kSize, 1);
  bad[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(values.insert(Key('a', 1), Variable<T>::type(), bad.data()), Error);
}

TYPED_TEST(UserVariable, PriorsHaveRightJacobians) {
  using T = TypeParam;
  Random random(3);
  for (int n = 0; n < 20; ++n) {
    Values values;
    values.insert(Key('a', 0), any<T>(random));
    const Prior<T> prior(Key('a', 0), any<T>(random), Noise::isotropic(T::kDim, 0.5));
    testing::expect_jacobians(prior, values, 1e-6);
  }
}

TEST(UserVariables, AutomaticJacobiansAreRight) {
  Random random(4);
  for (int n = 0; n < 20; ++n) {
    Values values;
    values.insert(Key('T', 0), any<Sim3>(random));
    values.insert(Key('p', 0), Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
    values.insert(Key('d', 0), any<S2>(random));
    values.insert(Key('r', 0), SO3::exp(Eigen::Vector3d(random.normal(), 0.3, random.normal())));
    const Eigen::Vector3d seen(random.normal(), random.normal(), random.normal());
    testing::expect_jacobians(
        PointFactor({Key('T', 0), Key('p', 0)}, PointThroughSim3{seen}, Noise::isotropic(3, 0.2)),
        values, 1e-6);
    testing::expect_jacobians(
        DirectionFactor({Key('r', 0), Key('d', 0)}, DirectionThroughSO3{seen.normalized()},
                        Noise::isotropic(3, 0.2)),
        values, 1e-6);
  }
}

/// Two similarities, each seeing the same points; the first is known.
class SimilarityWorld : public ::testing::Test {
 protected:
  SimilarityWorld() {
    Random random(5);
    const Sim3 first, second = any<Sim3>(random);
    truth_.insert(Key('T', 0), first);
    truth_.insert(Key('T', 1), second);
    add(std::make_shared<Prior<Sim3>>(Key('T', 0), first, Noise::isotropic(7, 0.01)));
    for (std::uint64_t i = 0; i < 6; ++i) {
      const Eigen::Vector3d p(2 * random.normal(), 2 * random.normal(), 2 * random.normal());
      truth_.insert(Key('p', i), p);
      for (std::uint64_t k = 0; k < 2; ++k) {
        const Sim3 T = truth_.at<Sim3>(Key('T', k));
        const Eigen::Vector3d noise(random.normal(), random.normal(), random.normal());
        const Eigen::Vector3d seen = T.rigid * Eigen::Vector3d(T.scale * p) + 0.01 * noise;
        add(std::make_shared<PointFactor>(std::array<Key, 2>{Key('T', k), Key('p', i)},
                                          PointThroughSim3{seen}, Noise::isotropic(3, 0.01)));
      }
    }
    for (Key key : truth_.keys()) {
      const VariableType type = truth_.type(key);
      Eigen::VectorXd delta(type.dim), moved(type.size);
      for (double& entry : delta) entry = 0.1 * random.normal();
      retract(type, truth_.data(key), delta.data(), moved.data());
      delta_.values.insert(key, type, moved.data());
    }
    initial_.values = delta_.values;
  }

  void add(ContinuousFactorPtr factor) {
    graph_.add(factor);
    delta_.continuous.push_back(std::move(factor));
  }

  static double distance(const Values& a, const Values& b) {
    double worst = 0;
    for (Key key : a.keys()) {
      if (!b.contains(key)) continue;
      const VariableType type = a.type(key);
      Eigen::VectorXd delta(type.dim);
      local(type, a.data(key), b.data(key), delta.data());
      worst = std::max(worst, delta.cwiseAbs().maxCoeff());
    }
    return worst;
  }

  HybridGraph graph_;
  Delta delta_;
  Values truth_;
  Estimate initial_;
};

TEST_F(SimilarityWorld, IsFoundInBatchAndOnlineAlike) {
  const AlternatingResult batch = alternate(graph_, initial_);
  EXPECT_EQ(batch.report.status, AlternatingStatus::kConverged);
  EXPECT_LT(distance(batch.estimate.values, truth_), 0.05);
  IncrementalSmoother smoother;
  ASSERT_EQ(smoother.update(delta_).status, UpdateReport::Status::kOk);
  smoother.converge();
  EXPECT_LT(distance(batch.estimate.values, smoother.values()), 1e-6);
}

TEST_F(SimilarityWorld, CovariancesAreThoseOfTheDenseInverse) {
  const AlternatingResult batch = alternate(graph_, initial_);
  const ContinuousMarginals marginals(graph_, batch.estimate);
  ASSERT_TRUE(marginals.valid());
  const std::vector<Key> keys = batch.estimate.values.keys();
  const Eigen::MatrixXd joint = marginals.joint_covariance(keys);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(joint.rows(), joint.cols());
  graph_.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    const Eigen::MatrixXd J = testing::linearization(*factor, batch.estimate.values).J;
    Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(J.rows(), joint.cols());
    int column = 0;
    for (std::size_t i = 0; i < factor->keys().size(); ++i) {
      int at = 0;
      for (Key key : keys) {
        if (key == factor->keys()[i]) break;
        at += batch.estimate.values.type(key).dim;
      }
      wide.middleCols(at, factor->types()[i].dim) = J.middleCols(column, factor->types()[i].dim);
      column += factor->types()[i].dim;
    }
    information += wide.transpose() * wide;
  });
  EXPECT_LT((joint * information - Eigen::MatrixXd::Identity(joint.rows(), joint.cols())).norm(),
            1e-4);
}

TEST_F(SimilarityWorld, LeavesAWindowAndStaysAsAPrior) {
  WindowOptions options;
  options.mode = WindowOptions::Mode::kFixedLag;
  options.lag = 1;
  WindowSmoother window(options);
  ASSERT_EQ(window.update(delta_).status, UpdateReport::Status::kOk);
  window.converge();
  const Values before = window.smoother().values();
  // Only the second similarity is touched from now on: the rest becomes a prior of it.
  for (int n = 0; n < 3; ++n) {
    Delta touch;
    touch.continuous.push_back(std::make_shared<Prior<Sim3>>(
        Key('T', 1), before.at<Sim3>(Key('T', 1)), Noise::isotropic(7, 10.0)));
    const WindowReport report = window.update(touch);
    ASSERT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
  }
  EXPECT_FALSE(window.smoother().values().contains(Key('p', 0)));
  window.converge();
  EXPECT_LT(distance(window.smoother().values(), before), 1e-6);
}

TEST(UserVariables, NumbersAndVectorsOfAnyLength) {
  HybridGraph graph;
  Estimate initial;
  const Key n('n', 0), v('v', 0), w('v', 1);
  initial.values.insert(n, 0.0);
  initial.values.insert(v, Eigen::VectorXd(Eigen::VectorXd::Zero(5)));
  initial.values.insert(w, Eigen::VectorXd(Eigen::VectorXd::Zero(5)));
  graph.emplace<Prior<double>>(n, 2.0, Noise::isotropic(1, 0.1));
  const Eigen::VectorXd z = Eigen::VectorXd::LinSpaced(5, 0, 1);
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(5, 5);
  const Noise noise = Noise::isotropic(5, 0.1);
  graph.emplace<LinearFactor>(std::vector<LinearFactor::Term>{{v, I}}, z, noise);
  // w = n + v
  graph.emplace<LinearFactor>(
      std::vector<LinearFactor::Term>{{w, I}, {v, -I}, {n, -Eigen::VectorXd::Ones(5)}},
      Eigen::VectorXd(Eigen::VectorXd::Zero(5)), noise);
  graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    testing::expect_jacobians(*factor, initial.values);
  });
  const AlternatingResult result = alternate(graph, initial);
  EXPECT_NEAR(result.estimate.values.at<double>(n), 2.0, 1e-9);
  const Eigen::VectorXd expected = z.array() + 2.0;
  EXPECT_LT((result.estimate.values.vector(w) - expected).norm(), 1e-9);
  EXPECT_THROW(result.estimate.values.at<SE2>(v), Error);
  EXPECT_THROW(LinearFactor({{v, I}}, Eigen::VectorXd::Zero(4), Noise::isotropic(4, 1)), Error);
  EXPECT_THROW(LinearFactor({}, z, noise), Error);
}

TEST(UserVariables, BetweenOfVectors) {
  HybridGraph graph;
  Estimate initial;
  const Key a('b', 0), b('b', 1);
  initial.values.insert(a, Eigen::Vector2d(0, 0));
  initial.values.insert(b, Eigen::Vector2d(5, 5));
  graph.emplace<Prior<Eigen::Vector2d>>(a, Eigen::Vector2d(1, 2), Noise::isotropic(2, 0.1));
  graph.emplace<Between<Eigen::Vector2d>>(a, b, Eigen::Vector2d(3, 4), Noise::isotropic(2, 0.1));
  graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    testing::expect_jacobians(*factor, initial.values);
  });
  const AlternatingResult result = alternate(graph, initial);
  EXPECT_LT((result.estimate.values.at<Eigen::Vector2d>(b) - Eigen::Vector2d(4, 6)).norm(), 1e-9);
}

}  // namespace
}  // namespace hybrid
