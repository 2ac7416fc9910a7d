// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Parts of the map that move as a whole: what that costs, and that nothing else follows from it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <vector>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/calibrated_bearing_range.h"
#include "libhybrid/factors/position.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/range.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/smoother/detail/pose_charts.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;

constexpr int kPart = 60;  // poses of each of two parts

/// A motion between two poses that counts how often it is evaluated.
class Observed : public ContinuousFactor {
 public:
  Observed(Key a, Key b, const SE2& z, double sigma, int& evaluated)
      : ContinuousFactor({a, b}, {Variable<SE2>::type(), Variable<SE2>::type()}, 3),
        factor_(a, b, z, Noise::isotropic(3, sigma)),
        evaluated_(evaluated) {}
  double cost(const double* const* x) const override {
    ++evaluated_;
    return factor_.cost(x);
  }
  double linearize(const double* const* x, double* r, double* J) const override {
    return factor_.linearize(x, r, J);
  }
  double log_normalizer() const override { return factor_.log_normalizer(); }
  std::string name() const override { return "observed"; }
  using ContinuousFactor::cost;

 private:
  BetweenSE2 factor_;
  int& evaluated_;
};

Key at(int k) {
  return {'x', static_cast<std::uint64_t>(k)};
}

/// Two parts, each a walk with many loops, of which the second hangs on the first by one motion.
class TwoParts {
 public:
  explicit TwoParts(std::uint64_t seed) : random_(seed) {
    for (int k = 0; k < 2 * kPart; ++k) {
      truth_.push_back(k == 0 ? SE2()
                              : truth_.back() * SE2(1.0, 0.0, 0.5 * random_.uniform(-1.0, 1.0)));
    }
  }

  /// Builds the map, first pose last, so that what hangs on the first part is far from the newest.
  void build(IncrementalSmoother& smoother) {
    for (int k = 2 * kPart - 1; k >= 0; --k) {
      Delta delta;
      delta.values.insert(at(k), k == 2 * kPart - 1 ? truth_[k]
                                                    : smoother.values().at<SE2>(at(k + 1)) *
                                                          truth_[k + 1].between(truth_[k]));
      if (k == 2 * kPart - 1) {
        prior_ = std::make_shared<Prior<SE2>>(at(k), truth_[k], Noise::isotropic(3, 1.0));
        delta.continuous.push_back(prior_);
      } else {
        add(delta, k, k + 1, k == kPart - 1 ? 0.5 : 0.05);
      }
      const int first = k < kPart ? 0 : kPart, last = k < kPart ? kPart : 2 * kPart;
      for (int n = 0; n < 2; ++n) {
        const int other = k + 2 + random_.below(10);
        if (other < last && k >= first) add(delta, k, other, 0.05);
      }
      const UpdateReport report = smoother.update(delta);
      ASSERT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
      if (k == 2 * kPart - 1) prior_handle_ = report.handles.continuous[0];
    }
    Delta moved;  // the first pose holds the map from now on
    moved.remove = {prior_handle_};
    moved.continuous.push_back(
        std::make_shared<Prior<SE2>>(at(0), truth_[0], Noise::isotropic(3, 0.01)));
    ASSERT_EQ(smoother.update(moved).status, UpdateReport::Status::kOk);
    smoother.converge();
  }

  /// What turns the second part about the hinge by some 20 degrees.
  Delta swing() const {
    Delta delta;
    delta.continuous.push_back(std::make_shared<BetweenSE2>(
        at(kPart - 1), at(kPart), hinge() * SE2(0.0, 0.0, 0.35), Noise::isotropic(3, 0.01)));
    return delta;
  }

  /// Of the factors of the second part, how many were evaluated since the last reset, and all.
  long evaluated() const { return all() - std::count(evaluated_.begin(), evaluated_.end(), 0); }
  long all() const { return static_cast<long>(evaluated_.size()); }
  void reset() { std::fill(evaluated_.begin(), evaluated_.end(), 0); }
  SE2 hinge() const { return truth_[kPart - 1].between(truth_[kPart]); }

 private:
  void add(Delta& delta, int a, int b, double sigma) {
    const SE2 noise(sigma * random_.normal(), sigma * random_.normal(),
                    0.2 * sigma * random_.normal());
    if (a >= kPart) evaluated_.push_back(0);
    delta.continuous.push_back(
        std::make_shared<Observed>(at(a), at(b), truth_[a].between(truth_[b]) * noise, sigma,
                                   a >= kPart ? evaluated_.back() : other_));
  }

  Random random_;
  std::vector<SE2> truth_;
  ContinuousFactorPtr prior_;
  Handle prior_handle_;
  std::deque<int> evaluated_;  // by factor of the second part
  int other_ = 0;
};

double most_bent(const Values& before, const Values& after) {
  double most = 0.0;
  for (int k = kPart + 1; k < 2 * kPart; ++k) {
    const SE2 was = before.at<SE2>(at(kPart)).between(before.at<SE2>(at(k)));
    const SE2 is = after.at<SE2>(at(kPart)).between(after.at<SE2>(at(k)));
    most = std::max(most, was.between(is).log().norm());
  }
  return most;
}

TEST(MovingParts, CostNoMoreThanWhatBends) {
  for (int seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    TwoParts parts(seed);
    IncrementalSmoother smoother;
    parts.build(smoother);
    const Values before = smoother.values();
    parts.reset();
    const UpdateReport report = smoother.update(parts.swing());
    ASSERT_EQ(report.status, UpdateReport::Status::kOk);
    // All of the second part has moved, by metres.
    EXPECT_GT((before.at<SE2>(at(2 * kPart - 1)).translation() -
               smoother.values().at<SE2>(at(2 * kPart - 1)).translation())
                  .norm(),
              0.5);
    EXPECT_GE(report.changed.size(), std::size_t(kPart));
    EXPECT_LT(most_bent(before, smoother.values()), 1e-3);
    EXPECT_GT(parts.all(), 100);
    EXPECT_LT(parts.evaluated(), parts.all() / 3);
    EXPECT_NEAR(smoother.objective(),
                objective(smoother.graph(), smoother.values(), smoother.assignment()), 1e-8);
  }
}

/// What comes of laps around a circle, each pose tied to that of the lap before.
struct LapsDriven {
  long work = 0;    // evaluations of factors, over all updates
  double open = 0;  // rise of the cost above the optimum, at the end
  double cost = 0;  // at the optimum

  LapsDriven(int seed, double bend, double bend_share) {
    constexpr int kLap = 80, kPoses = 5 * kLap;
    constexpr double kSigma = 0.05;
    const SE2 step(1.0, 0.0, 2 * M_PI / kLap);
    Random random(seed);
    std::deque<int> evaluated;
    const auto observe = [&](int a, int b, const SE2& z) {
      return std::make_shared<Observed>(at(a), at(b), z, kSigma, evaluated.emplace_back());
    };
    SmootherOptions options;
    options.bend = bend;
    options.bend_share = bend_share;
    IncrementalSmoother smoother(options);
    for (int k = 0; k < kPoses; ++k) {
      const SE2 z = step * random.value<SE2>(kSigma);
      Delta delta;
      delta.values.insert(at(k), k == 0 ? SE2() : smoother.values().at<SE2>(at(k - 1)) * z);
      if (k == 0) {
        const Noise noise = Noise::isotropic(3, kSigma);
        delta.continuous.push_back(std::make_shared<Prior<SE2>>(at(k), SE2(), noise));
      } else {
        delta.continuous.push_back(observe(k - 1, k, z));
      }
      if (k >= kLap) delta.continuous.push_back(observe(k - kLap, k, random.value<SE2>(kSigma)));
      smoother.update(delta);
    }
    for (const int n : evaluated) work += n;
    const double after = smoother.cost();
    smoother.converge(50, 1e-14);
    cost = smoother.cost();
    open = after - cost;
  }
};

// The noise leaves a cost of some units for ten factors; a thousandth of it is not worth the work.
TEST(MovingParts, MayStayBentByAShareOfWhatTheyCost) {
  constexpr double kShare = 1e-3;
  for (int seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const LapsDriven all(seed, 0.0, 0.0), share(seed, 0.0, kShare), more(seed, 0.0, 10 * kShare);
    EXPECT_LT(share.open, kShare * share.cost);
    EXPECT_LT(more.open, 10 * kShare * share.cost);
    EXPECT_LT(share.work, 7 * all.work / 10);
    EXPECT_LT(more.work, 9 * share.work / 10);
  }
}

TEST(MovingParts, ComeWhereABatchPutsThem) {
  for (int seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    TwoParts parts(seed);
    IncrementalSmoother smoother;
    parts.build(smoother);
    smoother.update(parts.swing());
    const double after = smoother.objective();
    smoother.converge(50, 1e-14);
    EXPECT_LT(after - smoother.objective(), 0.01);
    SolverOptions options;
    options.relative_decrease = 1e-14;
    const SolverResult batch = levenberg_marquardt(smoother.graph(), smoother.estimate(), options);
    for (int k = 0; k < 2 * kPart; ++k) {
      const SE2 off = batch.values.at<SE2>(at(k)).between(smoother.values().at<SE2>(at(k)));
      EXPECT_LT(off.log().norm(), 1e-6) << k;
    }
  }
}

TEST(MovingParts, HaveTheCovariancesOfTheirPlace) {
  TwoParts parts(7);
  IncrementalSmoother smoother;
  parts.build(smoother);
  smoother.update(parts.swing());
  const ContinuousMarginals exact(smoother.graph(), smoother.estimate());
  const std::vector<Key> keys = {at(kPart / 2), at(kPart + 5), at(2 * kPart - 1)};
  const Eigen::MatrixXd P = exact.joint_covariance(keys);
  const Eigen::MatrixXd found = smoother.joint_covariance(keys);
  const Eigen::VectorXd scale = P.diagonal().cwiseSqrt().cwiseInverse();
  EXPECT_LT((scale.asDiagonal() * (found - P) * scale.asDiagonal()).cwiseAbs().maxCoeff(), 0.02);
  smoother.visit_covariances([&](Key key, const Eigen::MatrixXd& covariance) {
    const Eigen::MatrixXd own = smoother.joint_covariance({key});
    EXPECT_LT((covariance - own).norm(), 1e-6 * own.norm());
  });
}

/// A part that a measurement holds in the map does not move past it.
TEST(MovingParts, StayWhereTheyAreHeld) {
  TwoParts parts(3);
  IncrementalSmoother smoother;
  parts.build(smoother);
  const SE2 held = smoother.values().at<SE2>(at(2 * kPart - 1));
  Delta delta;
  delta.continuous.push_back(
      std::make_shared<Prior<SE2>>(at(2 * kPart - 1), held, Noise::isotropic(3, 1e-3)));
  smoother.update(delta);
  smoother.update(parts.swing());
  smoother.converge();
  EXPECT_LT(held.between(smoother.values().at<SE2>(at(2 * kPart - 1))).log().norm(), 0.05);
}

/// A hybrid factor between the parts that is out of the tree sees them move past each other.
TEST(MovingParts, DecideAnewWhatDependsOnBoth) {
  TwoParts parts(4);
  IncrementalSmoother smoother;
  parts.build(smoother);
  const SE2 a = smoother.values().at<SE2>(at(10));
  const SE2 b = smoother.values().at<SE2>(at(2 * kPart - 10));
  const SE2 turned = smoother.values().at<SE2>(at(kPart - 1)) * parts.hinge() *
                     SE2(0.0, 0.0, 0.35) * smoother.values().at<SE2>(at(kPart)).between(b);
  const auto fits = std::make_shared<BetweenSE2>(at(10), at(2 * kPart - 10), a.between(turned),
                                                 Noise::isotropic(3, 0.3));
  Delta delta;
  const DiscreteKey choice{Key('d', 0), 2};
  delta.hybrid.push_back(std::make_shared<Mixture>(
      std::vector<DiscreteKey>{choice},
      std::vector<MixtureComponent>{{fits, 0.0, false}, {nullptr, 5.0, false}}));
  delta.assignment.set(choice.key, 1);
  smoother.update(delta);
  ASSERT_EQ(smoother.assignment().at(choice.key), 1);
  const UpdateReport report = smoother.update(parts.swing());
  EXPECT_EQ(report.flips, 1);
  EXPECT_EQ(smoother.assignment().at(choice.key), 0);
}

TEST(MovingParts, AreToldFromMeasurementsOfTheMap) {
  const Key x('x', 0), y('x', 1), l('l', 0);
  Values values;
  values.insert(x, SE2(30.0, -2.0, 0.4));
  values.insert(y, SE2(31.0, -1.0, -0.4));
  values.insert(l, Eigen::Vector2d(33.0, 4.0));
  const auto moves = [&](const ContinuousFactor& factor) {
    const auto at = gather(factor.keys(), factor.types(), values);
    return moves_with_map(VariableKind::kSE2, factor, at.data());
  };
  EXPECT_TRUE(moves(BetweenSE2(x, y, SE2(1, 0, 0), Noise::unit(3))));
  EXPECT_TRUE(moves(BearingRange2(x, l, {5, 1}, Noise::unit(2))));
  EXPECT_TRUE(moves(Range<SE2, Eigen::Vector2d>(x, l, 5, Noise::unit(1))));
  EXPECT_FALSE(moves(Prior<SE2>(x, SE2(), Noise::unit(3))));
  EXPECT_FALSE(moves(Prior<Eigen::Vector2d>(l, Eigen::Vector2d(1, 2), Noise::unit(2))));
  EXPECT_FALSE(moves(Position<SE2>(x, Eigen::Vector2d(1, 2), Noise::unit(2))));
  // Without a pose there is nothing to move with.
  const BetweenSE2 between(x, y, SE2(1, 0, 0), Noise::unit(3));
  const auto of_between = gather(between.keys(), between.types(), values);
  EXPECT_FALSE(moves_with_map(VariableKind::kVector, between, of_between.data()));
}

}  // namespace
}  // namespace hybrid
