// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "libhybrid/discrete/inference.h"
#include "libhybrid/factors/linear_factor.h"
#include "libhybrid/factors/linear_prior.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/smoother/divergence.h"
#include "libhybrid/switching/markov.h"
#include "tests/support/consistency.h"

namespace hybrid {
namespace {

using testing::PoseError;
using testing::SimulatedWalk;
using testing::WalkOptions;

WindowOptions bounded(int complete, int sightings, int tied = 1000) {
  WindowOptions options;
  options.mode = WindowOptions::Mode::kBounded;
  options.complete = complete;
  options.sightings = sightings;
  options.tied = tied;
  return options;
}

std::size_t count_poses(const Values& values) {
  const std::vector<Key> keys = values.keys();
  return static_cast<std::size_t>(
      std::count_if(keys.begin(), keys.end(), [](Key key) { return key.letter() == 'x'; }));
}

/// Whether two estimates are the same, bit by bit.
void expect_same(const Values& a, const Values& b) {
  ASSERT_EQ(a.keys(), b.keys());
  for (Key key : a.keys()) {
    const double *x = a.data(key), *y = b.data(key);
    EXPECT_TRUE(std::equal(x, x + a.type(key).size, y)) << to_string(key);
  }
}

TEST(BoundedWindow, IsFullSmoothingToTheLastBitAsLongAsItIsComplete) {
  WindowSmoother full, window(bounded(200, 5));
  SimulatedWalk<SE2> first({}, 3), second({}, 3);
  for (int t = 0; t < 200; ++t) {
    full.update(first.step(full.smoother().values()));
    EXPECT_TRUE(window.update(second.step(window.smoother().values())).left.empty());
  }
  expect_same(full.smoother().values(), window.smoother().values());
  EXPECT_EQ(full.smoother().objective(), window.smoother().objective());
  full.converge();
  window.converge();
  expect_same(full.smoother().values(), window.smoother().values());
  bool left = false;
  for (int t = 0; t < 100; ++t) {
    left = !window.update(second.step(window.smoother().values())).left.empty() || left;
  }
  EXPECT_TRUE(left);
}

// However long the robot stays, the graph is that of the place.
TEST(BoundedWindow, GraphAndMemoryStayAsTheyAreInAKnownPlace) {
  WindowSmoother window(bounded(150, 10));
  SimulatedWalk<SE2> world({}, 5);
  std::size_t poses = 0, factors = 0, bytes = 0;
  for (int t = 0; t < 1500; ++t) {
    const WindowReport report = window.update(world.step(window.smoother().values()));
    ASSERT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    EXPECT_TRUE(report.kept.empty()) << report.kept_because;
    const IncrementalSmoother& smoother = window.smoother();
    std::size_t& most_poses = poses;
    if (t < 500) {
      most_poses = std::max(most_poses, count_poses(smoother.values()));
      factors = std::max(factors, smoother.graph().size());
      bytes = std::max(bytes, smoother.memory().bytes);
    } else {
      EXPECT_LE(count_poses(smoother.values()), poses);
      EXPECT_LE(smoother.graph().size(), factors + factors / 4);
      EXPECT_LE(smoother.memory().bytes, bytes + bytes / 4);
    }
  }
  EXPECT_EQ(window.past().values.size() + count_poses(window.smoother().values()), 1500u);
  for (Key key : window.past().values.keys()) {
    ASSERT_NE(window.past_covariance(key), nullptr);
    EXPECT_GT(window.past_covariance(key)->determinant(), 0.0);
  }
}

// What is newly explored stays, and of a place as many sightings of each landmark as are asked for.
TEST(BoundedWindow, KeepsTheNewestSightingsOfEachLandmark) {
  const int sightings = 7;
  WindowSmoother window(bounded(100, sightings));
  SimulatedWalk<SE2> world({}, 8);
  std::map<Key, int> seen;
  for (int t = 0; t < 600; ++t) {
    const Delta delta = world.step(window.smoother().values());
    for (const auto& factor : delta.continuous) {
      for (Key key : factor->keys()) seen[key] += key.letter() == 'l' ? 1 : 0;
    }
    window.update(delta);
  }
  for (const auto& [key, count] : seen) {
    if (key.letter() != 'l') continue;
    int here = 0;
    for (Handle handle : window.smoother().factors_of(key)) {
      const ContinuousFactor& factor = *window.smoother().graph().continuous().at(handle);
      here += dynamic_cast<const LinearPrior*>(&factor) == nullptr ? 1 : 0;
    }
    EXPECT_GE(here, std::min(count, sightings)) << to_string(key);
  }
}

using Eigen::Vector2d;

ContinuousFactorPtr difference(Key a, Key b, const Vector2d& z, double sigma) {
  return std::make_shared<LinearFactor>(
      std::vector<LinearFactor::Term>{{a, -Eigen::Matrix2d::Identity()},
                                      {b, Eigen::Matrix2d::Identity()}},
      z, Noise::isotropic(2, sigma));
}

/// A linear world: states that walk in a circle and see the landmarks near them.
class LinearWorld {
 public:
  explicit LinearWorld(std::uint64_t seed, int landmarks) : random_(seed), landmarks_(landmarks) {}

  Delta step() {
    Delta delta;
    const Key now('x', static_cast<std::uint64_t>(t_));
    delta.values.insert(now, Vector2d(0.0, 0.0));
    if (t_ == 0) {
      delta.continuous.push_back(
          std::make_shared<Prior<Vector2d>>(now, Vector2d(0.0, 0.0), Noise::isotropic(2, 0.1)));
    } else {
      delta.continuous.push_back(
          difference(Key('x', static_cast<std::uint64_t>(t_ - 1)), now, noise(0.3), 0.3));
    }
    for (int k = 0; k < 3; ++k) {
      const Key landmark('l', static_cast<std::uint64_t>((t_ / 4 + k) % landmarks_));
      if (seen_.insert(landmark).second) delta.values.insert(landmark, Vector2d(0.0, 0.0));
      delta.continuous.push_back(difference(now, landmark, noise(0.5), 0.5));
    }
    ++t_;
    return delta;
  }

 private:
  Vector2d noise(double sigma) { return {random_.normal(sigma), random_.normal(sigma)}; }

  testing::Random random_;
  int landmarks_, t_ = 0;
  std::set<Key> seen_;
};

WindowOptions of_vectors(WindowOptions options) {
  options.states = "x";
  return options;
}

// Where all is linear, nothing is lost.
TEST(BoundedWindow, EqualsBatchOnALinearProblem) {
  WindowSmoother window(of_vectors(bounded(60, 5)));
  IncrementalSmoother full;
  LinearWorld first(2, 12), second(2, 12);
  for (int t = 0; t < 400; ++t) {
    window.update(first.step());
    full.update(second.step());
  }
  window.converge();
  full.converge();
  EXPECT_LT(window.smoother().values().size(), 150u);
  EXPECT_EQ(window.divergence(), 0.0);
  const std::vector<Key> keys = window.smoother().values().keys();
  for (Key key : keys) {
    EXPECT_LT(
        (window.smoother().values().at<Vector2d>(key) - full.values().at<Vector2d>(key)).norm(),
        1e-7)
        << to_string(key);
  }
  const Eigen::MatrixXd expected = full.joint_covariance(keys);
  EXPECT_LT((window.smoother().joint_covariance(keys) - expected).norm(), 1e-7 * expected.norm());
  EXPECT_NEAR(window.smoother().cost(), window.smoother().cost(), 1e-9);
}

/// NEES and squared error of the newest pose, means over runs and steps.
struct Score {
  double nees = 0.0, squares = 0.0;
};

template <class Pose>
Score score(const WindowOptions& window, const WalkOptions& options, int runs, int steps) {
  Score sum;
  for (int run = 0; run < runs; ++run) {
    testing::walk<Pose>(window, options, steps, 500 + static_cast<std::uint64_t>(run),
                        [&](int, const WindowSmoother&, const PoseError& error) {
                          sum.nees += error.nees / (runs * steps);
                          sum.squares += error.distance * error.distance / (runs * steps);
                        });
  }
  return sum;
}

/// Against full smoothing of the same 30 runs.
template <class Pose>
void expect_as_good_as_full(const WindowOptions& window, const WalkOptions& options, int steps) {
  const Score full = score<Pose>({}, options, 30, steps);
  const Score here = score<Pose>(window, options, 30, steps);
  EXPECT_NEAR(full.nees, 1.0, 0.25);
  EXPECT_GT(here.nees, 0.8 * full.nees);
  EXPECT_LT(here.nees, 1.25 * full.nees);
  EXPECT_LT(std::sqrt(here.squares), 1.05 * std::sqrt(full.squares));
}

TEST(BoundedWindow, IsAsGoodAndAsSureAsFullSmoothingInThePlane) {
  expect_as_good_as_full<SE2>(bounded(130, 10), {}, 300);
}

TEST(BoundedWindow, IsAsGoodAndAsSureAsFullSmoothingInSpace) {
  WalkOptions options;
  options.landmarks = 40;
  options.spread = 6.0;
  expect_as_good_as_full<SE3>(bounded(100, 10), options, 160);
}

/// Wheels that slip at times, in a chain of modes, beside four landmarks: in mode 1 the robot comes
/// half as far as it should.
Delta slip_step(int t, const Values& estimate, testing::Random& random, SE2& truth) {
  static const MarkovChain chain = sticky_chain(2, 0.8);
  const SE2 command(0.5, 0.0, 0.1), half(0.25, 0.0, 0.05);
  const Key now('x', static_cast<std::uint64_t>(t));
  Delta delta;
  SE2 start;
  if (t == 0) {
    delta.continuous.push_back(std::make_shared<Prior<SE2>>(now, SE2(), Noise::isotropic(3, 0.01)));
  } else {
    const Key before('x', static_cast<std::uint64_t>(t - 1));
    const DiscreteKey mode{Key('m', static_cast<std::uint64_t>(t)), 2};
    const bool slips = (t / 6) % 3 == 2;
    truth = truth * (slips ? half : command) * random.value<SE2>(slips ? 0.1 : 0.05);
    start = estimate.at<SE2>(before) * command;
    delta.hybrid.push_back(std::make_shared<Mixture>(
        std::vector<DiscreteKey>{mode},
        std::vector<MixtureComponent>{
            {std::make_shared<BetweenSE2>(before, now, command, Noise::isotropic(3, 0.05))},
            {std::make_shared<BetweenSE2>(before, now, half, Noise::isotropic(3, 0.1))}}));
    const DiscreteKey last{Key('m', static_cast<std::uint64_t>(t - 1)), 2};
    delta.discrete.push_back(t == 1 ? chain_tables(chain, {mode}).front()
                                    : chain_step(chain, last, mode));
  }
  delta.values.insert(now, start);
  for (int l = 0; l < 4; ++l) {
    const Key landmark('l', static_cast<std::uint64_t>(l));
    const Vector2d point(l < 2 ? -3.0 : 3.0, l % 2 == 0 ? 0.0 : 8.0);
    Vector2d z = to_polar(Vector2d(truth.inverse() * point));
    z += Vector2d(random.normal(0.2), random.normal(0.05));
    if (t == 0) delta.values.insert(landmark, point);
    delta.continuous.push_back(
        std::make_shared<BearingRange2>(now, landmark, z, Noise::diagonal(Vector2d(0.2, 0.05))));
  }
  return delta;
}

// Modes of motion that leave are fixed at their values; the loss is -log p of them, exactly.
TEST(BoundedWindow, FixesTheModesThatLeaveAndSaysWhatThatLoses) {
  testing::Random random(4);
  SE2 truth;
  WindowSmoother window(bounded(120, 5));
  double divergence = 0.0;
  for (int t = 0; t < 240; ++t) {
    const Delta delta = slip_step(t, window.smoother().values(), random, truth);
    IncrementalSmoother before = window.smoother();
    const WindowReport report = window.update(delta);
    ASSERT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    ASSERT_TRUE(report.kept.empty()) << report.kept_because;
    divergence += report.divergence;
    if (report.left_discrete.empty()) {
      EXPECT_EQ(report.divergence, 0.0);
      continue;
    }
    before.update(delta);  // what was there when they left
    const std::vector<const Table*> tables = before.component(report.left_discrete.front());
    std::vector<Table> held;
    Assignment values;
    for (Key key : report.left_discrete) values.set(key, window.past().assignment.at(key));
    for (const Table* table : tables) held.push_back(condition(*table, values));
    std::vector<const Table*> rest;
    for (const Table& table : held) rest.push_back(&table);
    const DiscreteMarginals expected = discrete_marginals(tables);
    EXPECT_NEAR(report.divergence,
                expected.log_partition() - discrete_marginals(rest).log_partition(), 1e-6);
    for (Key key : report.left_discrete) {
      ASSERT_NE(window.past_table(key), nullptr);
      const DiscreteMarginals here = discrete_marginals({window.past_table(key)});
      EXPECT_LT((expected.at(key) - here.at(key)).norm(), 1e-6) << to_string(key);
    }
  }
  EXPECT_GT(divergence, 0.0);
  EXPECT_EQ(divergence, window.divergence());
  // None of them is left behind.
  for (const auto& [key, value] : window.smoother().assignment()) {
    EXPECT_TRUE(window.smoother().values().contains(Key('x', key.index()))) << to_string(key);
  }
}

/// The information and the mean of all variables of a linear graph, dense.
struct Gaussian {
  Eigen::MatrixXd information;
  Eigen::VectorXd mean;
};

Gaussian dense(const IncrementalSmoother& smoother, const std::vector<Key>& keys) {
  std::map<Key, Eigen::Index> at;
  for (Key key : keys) at.emplace(key, 2 * static_cast<Eigen::Index>(at.size()));
  const auto n = 2 * static_cast<Eigen::Index>(keys.size());
  Gaussian out{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)};
  Eigen::VectorXd eta = Eigen::VectorXd::Zero(n);
  Values zero;
  for (Key key : keys) zero.insert(key, Vector2d(0.0, 0.0));
  smoother.graph().continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    const auto x = gather(factor->keys(), factor->types(), zero);
    Eigen::MatrixXd J(factor->rows(), factor->cols());
    Eigen::VectorXd r(factor->rows());
    factor->linearize(x.data(), r.data(), J.data());
    Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(factor->rows(), n);
    for (std::size_t i = 0; i < factor->keys().size(); ++i)
      wide.middleCols(at.at(factor->keys()[i]), 2) =
          J.middleCols(2 * static_cast<Eigen::Index>(i), 2);
    out.information += wide.transpose() * wide;
    eta -= wide.transpose() * r;
  });
  out.mean = out.information.ldlt().solve(eta);
  return out;
}

/// Kullback-Leibler divergence of p from q.
double divergence(const Gaussian& p, const Gaussian& q) {
  const Eigen::MatrixXd covariance = p.information.inverse();
  const Eigen::VectorXd apart = p.mean - q.mean;
  const double log_ratio =
      2.0 * (Eigen::MatrixXd(p.information.llt().matrixL()).diagonal().array().log().sum() -
             Eigen::MatrixXd(q.information.llt().matrixL()).diagonal().array().log().sum());
  return 0.5 * ((q.information * covariance).trace() - static_cast<double>(p.mean.size()) +
                log_ratio + apart.dot(q.information * apart));
}

TEST(BoundedWindow, DivergenceOfWhatIsLeftOutIsThatOfDenseGaussians) {
  IncrementalSmoother smoother;
  LinearWorld world(6, 9);
  for (int t = 0; t < 30; ++t) smoother.update(world.step());
  smoother.converge();
  const std::vector<Key> keys = smoother.values().keys();
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
    EXPECT_NEAR(here, divergence(dense(smoother, keys), dense(without, keys)), 1e-8);
    EXPECT_GT(here, 0.01);
  }
}

TEST(BoundedWindow, WhatAloneDeterminesSomethingCannotBeLeftOut) {
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
TEST(BoundedWindow, PriorsOfALargePlaceStaySmall) {
  const int tied = 6;
  WindowSmoother window(of_vectors(bounded(60, 5, tied)));
  IncrementalSmoother full;
  LinearWorld first(2, 40), second(2, 40);
  std::size_t poses = 0, factors = 0;
  for (int t = 0; t < 2400; ++t) {
    const WindowReport report = window.update(first.step());
    ASSERT_TRUE(report.kept.empty()) << report.kept_because;
    full.update(second.step());
    EXPECT_LE(most_tied(window.smoother().graph()), 2 * tied);
    const std::size_t now = count_poses(window.smoother().values());
    const std::size_t size = window.smoother().graph().size();
    if (t < 1200) {
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
  full.converge();
  // The means differ by what is lost, and the covariance is larger, never smaller.
  std::vector<Key> landmarks;
  for (std::uint64_t l = 0; l < 40; ++l) landmarks.emplace_back('l', l);
  const Eigen::MatrixXd here = window.smoother().joint_covariance(landmarks);
  const Eigen::MatrixXd best = full.joint_covariance(landmarks);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> gain(here - best);
  EXPECT_GT(gain.eigenvalues().minCoeff(), -1e-9);
  std::printf("poses %zu factors %zu breaks %d divergence %g trace %g %g\n", poses, factors,
              window.breaks(), window.divergence(), here.trace(), best.trace());
  for (Key key : landmarks) {
    const auto p = window.smoother().values().at<Vector2d>(key),
               q = full.values().at<Vector2d>(key);
    EXPECT_LT((p - q).norm(), 0.3) << to_string(key);
  }
}

}  // namespace
}  // namespace hybrid
