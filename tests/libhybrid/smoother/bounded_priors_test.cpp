// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// What a bounded window loses where it keeps its priors small.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>

#include "libhybrid/factors/linear_prior.h"
#include "libhybrid/smoother/detail/divergence.h"
#include "tests/support/bounded_walk.h"
#include "tests/support/dense_system.h"

namespace hybrid {
namespace {

using Eigen::Vector2d;
using testing::bounded;
using testing::count_poses;
using testing::DenseSystem;
using testing::LinearWalk;
using testing::of_vectors;

/// Kullback-Leibler divergence of p from q, both of the same variables, by dense matrices.
double divergence(const IncrementalSmoother& p, const IncrementalSmoother& q) {
  const DenseSystem of_p(p.graph(), p.estimate()), of_q(q.graph(), p.estimate());
  const Eigen::MatrixXd P = of_p.J.transpose() * of_p.J, Q = of_q.J.transpose() * of_q.J;
  const Eigen::VectorXd apart =
      P.ldlt().solve(of_p.J.transpose() * of_p.r) - Q.ldlt().solve(of_q.J.transpose() * of_q.r);
  const auto log_det = [](const Eigen::MatrixXd& A) {
    return 2.0 * Eigen::MatrixXd(A.llt().matrixL()).diagonal().array().log().sum();
  };
  return 0.5 * ((Q * P.inverse()).trace() - static_cast<double>(P.rows()) + log_det(P) -
                log_det(Q) + apart.dot(Q * apart));
}

TEST(BoundedPriors, DivergenceOfWhatIsLeftOutIsThatOfDenseGaussians) {
  IncrementalSmoother smoother;
  LinearWalk world(6, 9);
  for (int t = 0; t < 30; ++t) smoother.update(world.step());
  smoother.converge();
  for (int t : {3, 12, 25}) {
    IncrementalSmoother without = smoother;
    std::vector<const ContinuousFactor*> factors;
    Delta delta;
    smoother.graph().continuous().for_each([&](Handle handle, const ContinuousFactorPtr& factor) {
      const std::vector<Key>& held = factor->keys();
      if (held.size() != 2 || held[0] != Key('x', static_cast<std::uint64_t>(t)) ||
          held[1].letter() != 'x')
        return;
      factors.push_back(factor.get());
      delta.remove.push_back(handle);
    });
    ASSERT_EQ(factors.size(), 1u);
    const double here = divergence_without(
        factors, smoother.values(),
        [&](const std::vector<Key>& some) { return smoother.joint_covariance(some); });
    without.update(delta);
    EXPECT_NEAR(here, divergence(smoother, without), 1e-8);
    EXPECT_GT(here, 0.01);
  }
}

TEST(BoundedPriors, WhatAloneDeterminesSomethingCannotBeLeftOut) {
  IncrementalSmoother smoother;
  Delta delta;
  const Key x('x', 0);
  delta.values.insert(x, Vector2d(0.0, 0.0));
  delta.continuous.push_back(
      std::make_shared<Prior<Vector2d>>(x, Vector2d(1.0, 0.0), Noise::isotropic(2, 0.1)));
  smoother.update(delta);
  EXPECT_TRUE(std::isinf(divergence_without(
      {delta.continuous[0].get()}, smoother.values(),
      [&](const std::vector<Key>& some) { return smoother.joint_covariance(some); })));
}

/// Landmarks of the prior that holds most.
int most_tied(const HybridGraph& graph) {
  int most = 0;
  graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    if (dynamic_cast<const LinearPrior*>(factor.get()) == nullptr) return;
    const std::vector<Key>& keys = factor->keys();
    most = std::max(most, static_cast<int>(std::count_if(keys.begin(), keys.end(),
                                                         [](Key k) { return k.letter() == 'l'; })));
  });
  return most;
}

// In a place of many landmarks no prior ties more of them together than asked for, and the loss is
// told.
TEST(BoundedPriors, PriorsOfALargePlaceStaySmall) {
  const int tied = 6;
  WindowSmoother window(of_vectors(bounded(60, 5, tied)));
  IncrementalSmoother full;
  LinearWalk first(2, 24), second(2, 24);
  std::size_t poses = 0, factors = 0;
  for (int t = 0; t < 1600; ++t) {
    const WindowReport report = window.update(first.step());
    ASSERT_TRUE(report.kept.empty()) << report.kept_because;
    EXPECT_LE(most_tied(window.smoother().graph()), 2 * tied);
    const std::size_t now = count_poses(window.smoother().values());
    const std::size_t size = window.smoother().graph().size();
    if (t < 800) {
      poses = std::max(poses, now);
      factors = std::max(factors, size);
    } else {
      EXPECT_LE(now, poses + poses / 4);
      EXPECT_LE(size, factors + factors / 4);
    }
  }
  EXPECT_GT(window.breaks(), 10);
  EXPECT_GT(window.divergence(), 0.0);
  EXPECT_LT(window.divergence(), window.breaks());
  window.converge();
  full.update(second.steps(1600));
  full.converge();
  // The means differ by what is lost, and the covariance is larger, never smaller.
  std::vector<Key> landmarks;
  for (std::uint64_t l = 0; l < 24; ++l) landmarks.emplace_back('l', l);
  const Eigen::MatrixXd here = window.smoother().joint_covariance(landmarks);
  const Eigen::MatrixXd best = full.joint_covariance(landmarks);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> gain(here - best);
  EXPECT_GT(gain.eigenvalues().minCoeff(), -1e-9);
  for (Key key : landmarks) {
    const auto p = window.smoother().values().at<Vector2d>(key),
               q = full.values().at<Vector2d>(key);
    EXPECT_LT((p - q).norm(), 0.3) << to_string(key);
  }
}

}  // namespace
}  // namespace hybrid
