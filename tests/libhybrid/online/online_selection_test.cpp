// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/online/online_selection.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <random>
#include <utility>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::pose;
using testing::random_motion;

constexpr int kLap = 40;
constexpr double kSigma = 0.01;

/// A robot on a circle, with odometry of the stated noise.
template <class Group, class Factor>
struct Circle {
  explicit Circle(int poses, unsigned seed = 1) : rng(seed), truth(poses), odometry(poses) {
    const Group motion = testing::step_forward<Group>(2 * M_PI / kLap);
    for (int i = 1; i < poses; ++i) {
      truth[i] = truth[i - 1] * motion;
      odometry[i] = motion * random_motion<Group>(kSigma, rng);
    }
  }

  ContinuousFactorPtr between(int i, int j, const Group& measured) const {
    return std::make_shared<Factor>(pose(i), pose(j), measured,
                                    Noise::isotropic(Group::kDim, kSigma));
  }
  ContinuousFactorPtr closure(int i, int j) {
    return between(i, j, truth[i].between(truth[j]) * random_motion<Group>(kSigma, rng));
  }
  /// Pose i with its odometry, where the estimate puts it.
  Delta step(int i, const Values& estimate) const {
    Delta delta;
    if (i == 0) {
      delta.values.insert(pose(0), truth[0]);
      delta.continuous.push_back(
          std::make_shared<Prior<Group>>(pose(0), truth[0], Noise::isotropic(Group::kDim, 1e-3)));
      return delta;
    }
    delta.values.insert(pose(i), estimate.at<Group>(pose(i - 1)) * odometry[i]);
    delta.continuous.push_back(between(i - 1, i, odometry[i]));
    return delta;
  }
  double worst(const Values& values) const {
    double worst = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const Group estimate = values.at<Group>(pose(i));
      worst = std::max(worst, (estimate.translation() - truth[i].translation()).norm());
    }
    return worst;
  }

  std::mt19937 rng;
  std::vector<Group> truth, odometry;
};

using Planar = Circle<SE2, BetweenSE2>;

/// Runs all poses with the closures that arrive with them.
template <class Circle>
OnlineSelection run(const Circle& circle,
                    std::map<int, std::vector<ContinuousFactorPtr>> closures) {
  OnlineSelection selection;
  for (int i = 0; i < static_cast<int>(circle.truth.size()); ++i) {
    const SelectionReport report =
        selection.update(circle.step(i, selection.smoother().values()), closures[i]);
    EXPECT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
  }
  selection.finish();
  return selection;
}

template <class Type>
class OnlineSelectionOf : public ::testing::Test {};
using Circles = ::testing::Types<Planar, Circle<SE2, Between<SE2>>, Circle<SE3, Between<SE3>>>;
TYPED_TEST_SUITE(OnlineSelectionOf, Circles);

TYPED_TEST(OnlineSelectionOf, AcceptsTheTrueAndRejectsRandomLies) {
  TypeParam circle(3 * kLap);
  std::map<int, std::vector<ContinuousFactorPtr>> closures;
  std::vector<bool> truth;
  std::uniform_int_distribution<int> before(0, kLap - 1);
  for (int i = kLap; i < 3 * kLap; ++i) {
    closures[i].push_back(circle.closure(i - kLap, i));
    truth.push_back(true);
    const int j = before(circle.rng);
    using Group = std::decay_t<decltype(circle.truth[0])>;
    Group error;
    while (error.log().norm() < 1.0) error = random_motion<Group>(3.0, circle.rng);
    const auto lie = circle.truth[j].between(circle.truth[i]) * error;
    closures[i].push_back(circle.between(j, i, lie));
    truth.push_back(false);
  }
  const OnlineSelection selection = run(circle, closures);
  const std::vector<ClosureDecision> decisions = selection.decisions();
  ASSERT_EQ(decisions.size(), truth.size());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_EQ(decisions[k].accepted(), truth[k]) << "closure " << k;
    EXPECT_EQ(selection.status(k) == ClosureStatus::kAccepted, truth[k]);
    EXPECT_EQ(decisions[k].status, selection.status(k));
    EXPECT_EQ(decisions[k].evidence < 0.0, !truth[k]);
    EXPECT_EQ(decisions[k].inlier_probability > 0.5, truth[k]);
  }
  // The map is that of all trusted and true measurements together.
  HybridGraph graph;
  Estimate start;
  for (int i = 0; i < 3 * kLap; ++i) {
    start.values.insert(pose(i), circle.truth[i]);
    for (const auto& factor : circle.step(i, start.values).continuous) graph.add(factor);
    if (i >= kLap) graph.add(closures[i][0]);
  }
  SolverOptions exact;
  exact.relative_decrease = 1e-12;
  const Values optimum = levenberg_marquardt(graph, start, exact).values;
  EXPECT_LT(testing::distance(selection.smoother().values(), optimum), 1e-4);
  // Between evaluations of all closures, decisions are those that an evaluation comes to.
  OnlineSelection later = selection;
  later.update({});
  const std::vector<ClosureDecision> again = later.decisions();
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_NEAR(again[k].redundancy, decisions[k].redundancy, 1e-3) << "closure " << k;
    EXPECT_NEAR(again[k].inlier_probability, decisions[k].inlier_probability, 1e-3);
    EXPECT_EQ(again[k].checkable, decisions[k].checkable);
    if (std::isinf(decisions[k].margin)) {
      EXPECT_EQ(again[k].margin, decisions[k].margin) << "closure " << k;
    } else {
      EXPECT_NEAR(again[k].margin, decisions[k].margin, 0.1) << "closure " << k;
    }
  }
}

TEST(OnlineSelection, LiesThatAgreeWithEachOtherButNotWithTheOdometryStayOut) {
  Planar circle(2 * kLap);
  std::map<int, std::vector<ContinuousFactorPtr>> closures;
  // Another place that looks like the start: thirty closures to it, all shifted by the same 4 m.
  for (int i = kLap; i < kLap + 30; ++i) {
    const SE2 lie = SE2(4.0, 0.0, 0.0) * circle.truth[i - kLap].between(circle.truth[i]);
    closures[i].push_back(circle.between(i - kLap, i, lie));
  }
  const OnlineSelection selection = run(circle, closures);
  for (std::size_t k = 0; k < 30; ++k) EXPECT_EQ(selection.status(k), ClosureStatus::kRejected);
  OnlineSelection alone = run(circle, {});
  EXPECT_NEAR(circle.worst(selection.smoother().values()), circle.worst(alone.smoother().values()),
              1e-6);
}

TEST(OnlineSelection, ALieThatCouldNotBeCheckedIsThrownOutByLaterClosures) {
  Planar circle(2 * kLap);
  std::map<int, std::vector<ContinuousFactorPtr>> closures;
  // Inside what forty steps of odometry allow, forty times what the closure claims.
  const SE2 lie = circle.truth[0].between(circle.truth[kLap]) * SE2(0.0, 40 * kSigma, 0.0);
  closures[kLap].push_back(circle.between(0, kLap, lie));
  OnlineSelection early;
  for (int i = 0; i <= kLap; ++i) {
    early.update(circle.step(i, early.smoother().values()), closures[i]);
  }
  ASSERT_EQ(early.status(0), ClosureStatus::kAccepted);
  EXPECT_FALSE(early.decisions()[0].checkable);
  for (int i = kLap + 1; i < kLap + 20; ++i) closures[i].push_back(circle.closure(i - kLap, i));
  const OnlineSelection selection = run(circle, closures);
  EXPECT_EQ(selection.status(0), ClosureStatus::kRejected);
  for (std::size_t k = 1; k < 20; ++k)
    EXPECT_EQ(selection.status(k), ClosureStatus::kAccepted) << k;
}

// A step of which odometry is not sure, and off by four of its sigmas: no closure beyond it is
// credible alone.
TEST(OnlineSelection, ManyClosuresThatAgreeComeInBeforeTheEnd) {
  constexpr int kBreak = 260, kPoses = 340;
  Planar circle(kPoses);
  const Noise unsure = Noise::diagonal(Eigen::Vector3d(0.3, 0.3, 0.15));
  OnlineSelection selection;
  int known = 0;
  for (int i = 0; i < kPoses; ++i) {
    Delta step = circle.step(i, selection.smoother().values());
    if (i == kBreak) {
      const SE2 measured = circle.odometry[i] * SE2(1.2, -1.2, 0.6);
      step.continuous = {std::make_shared<BetweenSE2>(pose(i - 1), pose(i), measured, unsure)};
      step.values.update(pose(i), selection.smoother().values().at<SE2>(pose(i - 1)) * measured);
    }
    std::vector<ContinuousFactorPtr> closures;
    if (i >= kLap && (i < kBreak || i >= kBreak + 2)) {
      closures.push_back(circle.closure(i - (i < kBreak ? kLap : 2 * kLap), i));
      if (i < kBreak) ++known;
    }
    selection.update(step, closures);
    if (i == kBreak + 20) {
      EXPECT_NE(selection.status(known), ClosureStatus::kAccepted);
    }
  }
  EXPECT_EQ(selection.status(known), ClosureStatus::kAccepted);
  EXPECT_LT(circle.worst(selection.smoother().values()), 0.2);
}

TEST(OnlineSelection, LiesThatCameFirstGiveWayToTheTruth) {
  // Five lies that agree with each other and with the odometry, before anything true is seen.
  Planar circle(3 * kLap);
  std::map<int, std::vector<ContinuousFactorPtr>> closures;
  std::vector<bool> truth;
  for (int i = kLap; i < 3 * kLap; ++i) {
    const SE2 error = i < kLap + 5 ? SE2(0.0, 80 * kSigma, 0.0) : SE2();
    closures[i].push_back(
        circle.between(i - kLap, i, circle.truth[i - kLap].between(circle.truth[i]) * error));
    truth.push_back(i >= kLap + 5);
  }
  const OnlineSelection selection = run(circle, closures);
  const std::vector<ClosureDecision> decisions = selection.decisions();
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_EQ(selection.status(k) == ClosureStatus::kAccepted, truth[k]) << k;
    EXPECT_EQ(decisions[k].accepted(), truth[k]) << k;
    EXPECT_EQ(decisions[k].inlier_probability > 0.5, truth[k]) << k;
  }
}

TEST(OnlineSelection, ObjectiveIsThatOfTheMixture) {
  Planar circle(2 * kLap);
  std::map<int, std::vector<ContinuousFactorPtr>> closures;
  for (int i = kLap; i < 2 * kLap; i += 3) closures[i].push_back(circle.closure(i - kLap, i));
  closures[50].push_back(circle.between(3, 50, SE2(1.0, 7.0, 1.0)));
  const OnlineSelection selection = run(circle, closures);
  HybridGraph graph;
  selection.smoother().graph().continuous().for_each(
      [&](Handle, const ContinuousFactorPtr& factor) { graph.add(factor); });
  selection.smoother().graph().hybrid().for_each(
      [&](Handle, const HybridFactorPtr& factor) { graph.add(factor); });
  EXPECT_NEAR(selection.smoother().objective(),
              objective(graph, selection.smoother().values(), selection.smoother().assignment()),
              1e-6);
}

TEST(OnlineSelection, OverstatedNoiseDoesNotOpenTheGate) {
  // The odometry is a hundred times better than it claims; lies of 1 m are inside its claims.
  constexpr double kClaimed = 100 * 1e-3;
  std::mt19937 rng(5);
  OnlineSelection selection;
  std::vector<SE2> truth(4 * kLap);
  std::vector<bool> truths;
  for (int i = 0; i < 4 * kLap; ++i) {
    Delta delta;
    std::vector<ContinuousFactorPtr> closures;
    const auto between = [&](int a, int b, const SE2& z) {
      return std::make_shared<BetweenSE2>(pose(a), pose(b), z, Noise::isotropic(3, kClaimed));
    };
    if (i == 0) {
      delta = Planar(1).step(0, {});
    } else {
      const SE2 motion = testing::step_forward<SE2>(2 * M_PI / kLap);
      truth[i] = truth[i - 1] * motion;
      const SE2 z = motion * random_motion<SE2>(1e-3, rng);
      delta.values.insert(pose(i), selection.smoother().values().at<SE2>(pose(i - 1)) * z);
      delta.continuous.push_back(between(i - 1, i, z));
    }
    if (i >= kLap) {
      closures.push_back(between(i - kLap, i, truth[i - kLap].between(truth[i])));
      truths.push_back(true);
    }
    if (i >= 3 * kLap && i % 4 == 0) {
      closures.push_back(between(i - 20, i, truth[i - 20].between(truth[i]) * SE2(1.0, 0.0, 0.0)));
      truths.push_back(false);
    }
    selection.update(delta, closures);
  }
  selection.finish();
  for (std::size_t k = 0; k < truths.size(); ++k) {
    EXPECT_EQ(selection.status(k) == ClosureStatus::kAccepted, truths[k]) << k;
  }
}

TEST(OnlineSelection, BadInputLeavesItAsItWas) {
  Planar circle(4);
  OnlineSelection selection;
  for (int i = 0; i < 3; ++i) selection.update(circle.step(i, selection.smoother().values()), {});
  const ContinuousFactorPtr unknown = circle.between(0, 9, SE2());
  EXPECT_THROW(selection.update(circle.step(3, selection.smoother().values()), {unknown}), Error);
  EXPECT_TRUE(selection.decisions().empty());
  const SelectionReport report =
      selection.update(circle.step(3, selection.smoother().values()), {circle.closure(0, 3)});
  EXPECT_EQ(report.status, UpdateReport::Status::kOk);
  EXPECT_EQ(selection.decisions().size(), 1u);
}

TEST(OnlineSelection, SwitchesOfTheUserHaveLettersOfTheirOwn) {
  const auto motion = [](int i, double x) {
    return std::make_shared<BetweenSE2>(pose(i), pose(i + 1), SE2(x, 0, 0),
                                        Noise::isotropic(3, 0.1));
  };
  const auto delta = [&](Key key) {
    Delta d;
    for (int i = 0; i < 3; ++i) d.values.insert(pose(i), SE2(i, 0, 0));
    d.continuous = {std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.1)),
                    motion(1, 1.0)};
    d.hybrid = {std::make_shared<Mixture>(
        std::vector<DiscreteKey>{{key, 2}},
        std::vector<MixtureComponent>{{motion(0, 1.0), 0.0}, {motion(0, 5.0), 1.0}})};
    return d;
  };
  const std::vector<ContinuousFactorPtr> closures = {
      std::make_shared<BetweenSE2>(pose(0), pose(2), SE2(2, 0, 0), Noise::isotropic(3, 0.1))};
  for (const Key key : {Key('D', 0), Key('D', 900)}) {
    OnlineSelection selection;
    try {
      selection.update(delta(key), closures);
      ADD_FAILURE() << "accepted";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(to_string(key) + ": the letter D"),
                std::string::npos)
          << error.what();
    }
    EXPECT_EQ(selection.smoother().values().size(), 0u);
    EXPECT_EQ(selection.update(delta(Key('u', 900)), closures).status, UpdateReport::Status::kOk);
    EXPECT_EQ(selection.finish().status, UpdateReport::Status::kOk);
    EXPECT_EQ(selection.status(0), ClosureStatus::kAccepted);
  }
}

TEST(OnlineSelection, APoseThatOnlyAClosureHoldsIsNamed) {
  Planar circle(3);
  OnlineSelection selection;
  for (int i = 0; i < 2; ++i) selection.update(circle.step(i, selection.smoother().values()), {});
  Delta delta;
  delta.values.insert(pose(2), SE2());
  const SelectionReport report = selection.update(delta, {circle.closure(0, 2)});
  EXPECT_EQ(report.status, UpdateReport::Status::kSingular);
  EXPECT_NE(report.message.find("x2"), std::string::npos) << report.message;
  EXPECT_TRUE(selection.decisions().empty());
}

}  // namespace
}  // namespace hybrid
