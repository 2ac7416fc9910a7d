// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Bad input names the key and leaves the smoother as it was.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "libhybrid/hybrid/semantic.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/solvers/alternating.h"
#include "tests/support/hard_factors.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::distance;
using testing::pose;

ContinuousFactorPtr between(int i, int j, const SE2& z, double sigma = 0.05) {
  return std::make_shared<BetweenSE2>(pose(i), pose(j), z, Noise::isotropic(3, sigma));
}

DiscreteKey discrete(int i, int cardinality = 2) {
  return {Key('d', static_cast<std::uint64_t>(i)), cardinality};
}

HybridFactorPtr closure(int number, int i, int j, const SE2& z) {
  return make_outlier_mixture(discrete(number), between(i, j, z),
                              between(i, j, z, 0.05 * std::sqrt(1e7)), 0.5, 0.5);
}

/// Everything a user can see of a smoother.
std::vector<double> snapshot(const IncrementalSmoother& smoother) {
  std::vector<double> all = {smoother.objective(),
                             smoother.cost(),
                             double(smoother.graph().size()),
                             double(smoother.values().size()),
                             double(smoother.assignment().size()),
                             double(smoother.tree().cliques().factor_size())};
  const std::vector<Key> keys = smoother.values().keys();
  for (Key key : keys) {
    const double* x = smoother.values().data(key);
    all.insert(all.end(), x, x + smoother.values().type(key).size);
  }
  const Eigen::MatrixXd covariance = smoother.joint_covariance(keys);
  all.insert(all.end(), covariance.data(), covariance.data() + covariance.size());
  double sum = 0.0;  // the order of an assignment is not told
  for (const auto& [key, value] : smoother.assignment()) sum += double(key.index() + 1) * value;
  all.push_back(sum);
  return all;
}

class BadInput : public ::testing::Test {
 protected:
  void SetUp() override {
    Delta delta;
    for (int i = 0; i < 12; ++i) delta.values.insert(pose(i), SE2(i, 0.1 * i, 0.0));
    delta.continuous.push_back(
        std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.01)));
    for (int i = 1; i < 12; ++i) delta.continuous.push_back(between(i - 1, i, SE2(1.0, 0.0, 0.02)));
    delta.hybrid.push_back(closure(0, 0, 6, SE2(5.9, 0.3, 0.1)));
    delta.hybrid.push_back(closure(1, 2, 9, SE2(1.0, 8.0, 2.0)));
    handles_ = smoother_.update(delta).handles.all();
    ASSERT_EQ(handles_.size(), 14u);
    before_ = snapshot(smoother_);
  }

  void expect_usable() {
    EXPECT_EQ(snapshot(smoother_), before_);
    Delta good;
    good.values.insert(pose(12), smoother_.values().at<SE2>(pose(11)));
    good.continuous.push_back(between(11, 12, SE2(1.0, 0.0, 0.0)));
    good.hybrid.push_back(closure(7, 4, 12, SE2(7.9, 0.4, 0.1)));
    ASSERT_EQ(smoother_.update(good).status, UpdateReport::Status::kOk);
    smoother_.converge(100, 1e-15);
    AlternatingOptions options;
    options.relative_decrease = 1e-15;
    options.continuous.relative_decrease = 1e-15;
    const AlternatingResult batch = alternate(smoother_.graph(), smoother_.estimate(), options);
    EXPECT_EQ(batch.estimate.assignment, smoother_.assignment());
    EXPECT_LT(distance(batch.estimate.values, smoother_.values()), 1e-6);
  }

  void expect_error(const Delta& delta, const std::string& named) {
    try {
      smoother_.update(delta);
      ADD_FAILURE() << "accepted, though " << named << " is wrong";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
    }
    expect_usable();
  }

  void expect_singular(const Delta& delta, const std::vector<Key>& any_of) {
    const UpdateReport report = smoother_.update(delta);
    EXPECT_EQ(report.status, UpdateReport::Status::kSingular);
    EXPECT_NE(std::find(any_of.begin(), any_of.end(), report.under_constrained), any_of.end())
        << report.under_constrained;
    EXPECT_NE(report.message.find(to_string(report.under_constrained)), std::string::npos);
    EXPECT_TRUE(report.handles.empty());
    expect_usable();
  }

  IncrementalSmoother smoother_;
  std::vector<Handle> handles_;
  std::vector<double> before_;
};

TEST_F(BadInput, DisconnectedVariables) {
  Delta delta;
  for (int i : {20, 21}) delta.values.insert(pose(i), SE2());
  delta.continuous.push_back(between(20, 21, SE2()));
  delta.hybrid.push_back(closure(3, 1, 7, SE2(6.0, 0.0, 0.0)));
  expect_singular(delta, {pose(20), pose(21)});
}

TEST_F(BadInput, SingularByRemoval) {
  Delta delta;
  delta.remove = {handles_[0], handles_[13]};
  std::vector<Key> keys = smoother_.values().keys();
  expect_singular(delta, keys);
}

TEST_F(BadInput, SingularWithRemovedFactorsTablesAndFlips) {
  Delta delta;
  delta.remove = {handles_[11], handles_[12]};  // the last odometry
  delta.discrete.push_back(Table({discrete(1)}, {-1e6, 0.0}));
  expect_singular(delta, {pose(11)});
}

TEST_F(BadInput, DuplicateKeys) {
  Delta delta;
  delta.values.insert(pose(5), SE2());
  expect_error(delta, "x5");
}

TEST_F(BadInput, UnknownVariable) {
  Delta delta;
  delta.continuous.push_back(between(3, 44, SE2()));
  expect_error(delta, "x44");
}

TEST_F(BadInput, WrongType) {
  Delta delta;
  delta.values.insert(Key('l', 1), Eigen::Vector2d(1.0, 2.0));
  delta.continuous.push_back(
      std::make_shared<BetweenSE2>(pose(0), Key('l', 1), SE2(), Noise::isotropic(3, 0.1)));
  expect_error(delta, "l1");
}

TEST_F(BadInput, VariableRemovedAndUsed) {
  Delta delta;
  delta.remove = {handles_[11]};
  delta.remove_values = {pose(11)};
  delta.continuous.push_back(between(10, 11, SE2()));
  expect_error(delta, "x11");
}

TEST_F(BadInput, VariableRemovedWhileHeld) {
  Delta delta;
  delta.remove_values = {pose(11)};
  expect_error(delta, "x11");
}

TEST_F(BadInput, VariableRemovedTwice) {
  Delta delta;
  delta.remove = {handles_[11]};
  delta.remove_values = {pose(11), pose(11)};
  expect_error(delta, "x11");
}

TEST_F(BadInput, FactorRemovedTwice) {
  Delta delta;
  delta.remove = {handles_[12], handles_[12]};
  expect_error(delta, "twice");
}

TEST_F(BadInput, FactorThatIsGone) {
  Delta add;
  add.continuous.push_back(between(0, 11, SE2(11.0, 0.0, 0.0)));
  Delta remove;
  remove.remove = smoother_.update(add).handles.all();
  smoother_.update(remove);
  before_ = snapshot(smoother_);
  expect_error(remove, "no longer");
}

TEST_F(BadInput, ResidualNotANumber) {
  Delta delta;
  delta.continuous.push_back(std::make_shared<testing::UndefinedMotion>(pose(3), pose(8)));
  expect_error(delta, "undefined factor on x3 x8");
}

TEST_F(BadInput, HybridResidualNotANumber) {
  Delta delta;
  delta.hybrid.push_back(
      make_outlier_mixture(discrete(4), between(3, 8, SE2(5.0, 0.0, 0.0)),
                           std::make_shared<testing::UndefinedMotion>(pose(3), pose(8)), 0.5, 0.5));
  expect_error(delta, "d4");
}

TEST_F(BadInput, CardinalitiesThatDisagree) {
  Delta delta;
  delta.discrete.push_back(Table({discrete(0, 3)}, {0.0, 1.0, 2.0}));
  expect_error(delta, "d0");
}

TEST_F(BadInput, InitialValueOutOfRange) {
  Delta delta;
  delta.discrete.push_back(Table({discrete(9)}, {0.0, 1.0}));
  delta.assignment.set(discrete(9).key, 2);
  expect_error(delta, "d9");
}

TEST_F(BadInput, ASnapshotOfOtherVariables) {
  const IncrementalSmoother::Snapshot old = smoother_.snapshot();
  smoother_.restore(old);
  Delta more;
  more.values.insert(pose(12), SE2(12, 0, 0));
  more.continuous.push_back(between(11, 12, SE2(1.0, 0.0, 0.0)));
  smoother_.update(more);
  EXPECT_THROW(smoother_.restore(old), Error);
  IncrementalSmoother a, b;  // as many numbers, of another variable
  Delta first, second;
  first.values.insert(pose(1), SE2(100, 0, 0));
  first.continuous.push_back(
      std::make_shared<Prior<SE2>>(pose(1), SE2(100, 0, 0), Noise::isotropic(3, 0.1)));
  second.values.insert(pose(7), SE2());
  second.continuous.push_back(
      std::make_shared<Prior<SE2>>(pose(7), SE2(), Noise::isotropic(3, 0.1)));
  a.update(first);
  b.update(second);
  EXPECT_THROW(b.restore(a.snapshot()), Error);
  EXPECT_EQ(b.values().at<SE2>(pose(7)).translation()[0], 0.0);
}

TEST(BadInputLimits, ATableOverTheLimit) {
  SmootherOptions options;
  options.discrete.max_table = 100;
  options.discrete.local_search_when_too_large = false;
  IncrementalSmoother smoother(options);
  Delta first;
  first.values.insert(pose(0), SE2());
  first.continuous.push_back(
      std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.01)));
  first.discrete.push_back(Table({discrete(0, 20)}, std::vector<double>(20, 1.0)));
  first.discrete.push_back(Table({discrete(1, 20)}, std::vector<double>(20, 1.0)));
  smoother.update(first);
  const std::vector<double> before = snapshot(smoother);
  Delta large;
  large.values.insert(pose(1), SE2(1.0, 0.0, 0.0));
  large.continuous.push_back(between(0, 1, SE2(1.1, 0.0, 0.0)));
  large.discrete.push_back(
      Table({discrete(0, 20), discrete(1, 20)}, std::vector<double>(400, 0.5)));
  try {
    smoother.update(large);
    ADD_FAILURE() << "a table of 400 entries passed a limit of 100";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("d0"), std::string::npos) << error.what();
  }
  EXPECT_EQ(snapshot(smoother), before);
  large.discrete.clear();
  EXPECT_EQ(smoother.update(large).status, UpdateReport::Status::kOk);
}

TEST(ImpossibleValues, LeaveNoTraceInTheObjective) {
  const double infinity = std::numeric_limits<double>::infinity();
  IncrementalSmoother smoother;
  Delta delta;
  delta.values.insert(pose(0), SE2());
  delta.values.insert(Key('l', 0), Eigen::Vector2d(2.0, 0.0));
  delta.continuous.push_back(
      std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.01)));
  delta.discrete.push_back(Table({discrete(0)}, {infinity, 0.5}));  // starts at the impossible
  delta.hybrid.push_back(make_semantic_bearing_range<SE2>(
      pose(0), Key('l', 0), discrete(1, 3), {2.1, 0.1}, Noise::isotropic(2, 0.1), {0.0, 0.3, 0.7}));
  ASSERT_EQ(smoother.update(delta).status, UpdateReport::Status::kOk);
  EXPECT_EQ(smoother.assignment().at(discrete(0).key), 1);
  EXPECT_EQ(smoother.assignment().at(discrete(1).key), 2);
  EXPECT_TRUE(std::isfinite(smoother.objective()));
  EXPECT_NEAR(smoother.objective(),
              objective(smoother.graph(), smoother.values(), smoother.assignment()), 1e-9);
}

TEST(ImpossibleValues, AreRefusedWhereThereIsNoOther) {
  const double infinity = std::numeric_limits<double>::infinity();
  IncrementalSmoother smoother;
  Delta delta;
  delta.values.insert(pose(0), SE2());
  const auto prior = std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.01));
  delta.continuous.push_back(prior);
  delta.discrete.push_back(Table({discrete(0)}, {0.0, infinity}));
  smoother.update(delta);
  const std::vector<double> before = snapshot(smoother);
  std::vector<Delta> impossible(4);
  impossible[0].discrete.push_back(Table({discrete(0)}, {infinity, 0.0}));
  impossible[1].discrete.push_back(Table({discrete(1)}, {infinity, infinity}));
  impossible[2].hybrid.push_back(std::make_shared<Mixture>(
      std::vector<DiscreteKey>{discrete(1)},
      std::vector<MixtureComponent>{{prior, infinity}, {nullptr, infinity}}));
  for (int i = 0; i < 2; ++i) {
    impossible[3].hybrid.push_back(
        std::make_shared<Mixture>(std::vector<DiscreteKey>{discrete(1)},
                                  std::vector<MixtureComponent>{{prior, 1e308}, {prior, 1e308}}));
  }
  for (std::size_t i = 0; i < impossible.size(); ++i) {
    const std::string name = i == 0 ? "d0" : "d1";
    try {
      smoother.update(impossible[i]);
      ADD_FAILURE() << i;
    } catch (const Error& error) {
      EXPECT_EQ(error.what(),
                "no joint value of " + name + " is possible: every one has infinite cost");
    }
    EXPECT_EQ(snapshot(smoother), before);
  }
  EXPECT_EQ(smoother.converge().status, UpdateReport::Status::kOk);
}

TEST(Convergence, NeedsAToleranceThatCanBeMet) {
  IncrementalSmoother smoother;
  for (const double wrong : {std::nan(""), -1.0}) EXPECT_THROW(smoother.converge(3, wrong), Error);
}

/// With one round per update, the flip that follows from a step stays for the next update; one that
/// fails must not lose it.
TEST(FlipsOfTheLastRound, SurviveAFailedUpdate) {
  SmootherOptions options;
  options.rounds = 1;
  IncrementalSmoother smoother(options);
  Delta delta;
  for (int i = 0; i < 10; ++i) delta.values.insert(pose(i), SE2(1.3 * i, 0.0, 0.0));
  delta.continuous.push_back(
      std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.01)));
  for (int i = 1; i < 10; ++i) delta.continuous.push_back(between(i - 1, i, SE2(1.0, 0.0, 0.0)));
  delta.hybrid.push_back(closure(0, 0, 9, SE2(9.1, 0.0, 0.0)));
  delta.assignment.set(discrete(0).key, 1);
  const UpdateReport report = smoother.update(delta);
  ASSERT_EQ(report.flips, 1);
  ASSERT_EQ(smoother.assignment().at(discrete(0).key), 0);
  const std::vector<double> before = snapshot(smoother);
  Delta bad;
  bad.values.insert(pose(20), SE2());
  EXPECT_EQ(smoother.update(bad).status, UpdateReport::Status::kSingular);
  EXPECT_EQ(snapshot(smoother), before);
  smoother.converge(100, 1e-15);
  const AlternatingResult batch = alternate(smoother.graph(), smoother.estimate());
  EXPECT_LT(distance(batch.estimate.values, smoother.values()), 1e-6);
  EXPECT_NEAR(batch.report.objective, smoother.objective(), 1e-6);
}

}  // namespace
}  // namespace hybrid
