// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// What goes wrong inside a change leaves the selection of closures and choices as it was.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/factors/position.h"
#include "libhybrid/online/online_selection.h"
#include "libhybrid/pose_graph/pose_feed.h"
#include "tests/support/changing_world.h"
#include "tests/support/fragile_factor.h"

namespace hybrid {
namespace {

using testing::between;
using testing::FragileFactor;
using testing::pose;
using testing::random_motion;

/// All that can be asked of a judge, as numbers.
std::vector<double> state_of(const OnlineSelection& judge) {
  std::vector<double> all = testing::state(judge.smoother());
  const std::vector<ClosureDecision> decisions = judge.decisions();
  for (std::size_t k = 0; k < decisions.size(); ++k) {
    all.push_back(static_cast<double>(judge.status(k)));
    for (double x : {decisions[k].inlier_probability, decisions[k].redundancy}) all.push_back(x);
  }
  all.push_back(judge.trials());
  all.push_back(static_cast<double>(judge.waiting()));
  return all;
}

/// One change after the other, made for the estimate at hand, of which all factors are fragile.
template <class Judge>
class Course {
 public:
  virtual ~Course() = default;
  virtual void step(Judge& judge, int k) const = 0;
  virtual int steps() const = 0;

  std::shared_ptr<testing::Fuse> fuse = std::make_shared<testing::Fuse>();

 protected:
  ContinuousFactorPtr fragile(ContinuousFactorPtr factor) const {
    return std::make_shared<FragileFactor>(std::move(factor), fuse);
  }
};

/// Whether the course of one that never saw a failure is that of one that did, to the last bit.
template <class Judge>
void expect_same_course(const Course<Judge>& course, int k, Judge spared, Judge& struck) {
  ASSERT_EQ(state_of(struck), state_of(spared));
  for (int next = k; next < std::min(k + 3, course.steps() + 1); ++next) {
    for (Judge* judge : {&spared, &struck}) {
      next < course.steps() ? course.step(*judge, next) : void(judge->finish());
    }
    ASSERT_EQ(state_of(struck), state_of(spared)) << "at step " << next;
  }
}

/// Lets the n-th use of a factor fail, for all n, or many of very many, in each step and in the
/// end. Returns how often one failed.
template <class Judge>
int fail_everywhere(const Course<Judge>& course) {
  int failures = 0;
  Judge judge;
  for (int k = 0; k <= course.steps(); ++k) {
    for (int n = 1;; n += 1 + n / 25) {
      Judge struck = judge;
      course.fuse->arm(n);
      try {
        k < course.steps() ? course.step(struck, k) : void(struck.finish());
        course.fuse->disarm();
        break;
      } catch (const std::domain_error&) {
        ++failures;
      }
      course.fuse->disarm();
      SCOPED_TRACE("step " + std::to_string(k) + ", use " + std::to_string(n));
      // After any failure the state is the one before; what comes next takes long to compare.
      EXPECT_EQ(state_of(struck), state_of(judge));
      if (n < 4 || n % 7 == 0) expect_same_course(course, k, judge, struck);
      if (::testing::Test::HasFailure()) return failures;
    }
    if (k < course.steps()) course.step(judge, k);
  }
  return failures;
}

/// The first pose of a course.
void add_origin(Delta& delta) {
  delta.values.insert(pose(0), SE2());
  delta.continuous.push_back(
      std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.01)));
}

/// Two laps with closures, true ones and false ones.
class FragileLaps : public Course<OnlineSelection> {
 public:
  FragileLaps() {
    std::mt19937 rng(3);
    for (int i = 0; i < 2 * kLap; ++i) {
      noise_.push_back(random_motion<SE2>(0.02, rng));
      closure_noise_.push_back(random_motion<SE2>(i % 5 == 2 ? 0.7 : 0.02, rng));
    }
  }
  int steps() const override { return 2 * kLap; }
  void step(OnlineSelection& judge, int k) const override {
    Delta delta;
    if (k == 0) {
      add_origin(delta);
    } else {
      const SE2 z = kMotion * noise_[k];
      delta.values.insert(pose(k), judge.smoother().values().at<SE2>(pose(k - 1)) * z);
      delta.continuous.push_back(fragile(between(k - 1, k, z, 0.02)));
    }
    std::vector<ContinuousFactorPtr> closures;
    for (int old : {k - kLap, k - kLap + 1}) {
      if (old < 0 || k < kLap) continue;
      const SE2 z = old == k - kLap ? closure_noise_[k] : kMotion.inverse() * closure_noise_[old];
      closures.push_back(fragile(between(old, k, z, 0.02)));
    }
    judge.update(delta, closures);
  }

 private:
  static constexpr int kLap = 13;
  const SE2 kMotion{1.0, 0.0, 2 * M_PI / kLap};
  std::vector<SE2> noise_, closure_noise_;
};

TEST(OnlineSelection, AFactorThatThrowsAnywhereLeavesItAsItWas) {
  EXPECT_GT(fail_everywhere(FragileLaps()), 500);
}

/// Two laps with choices among the steps, and closures that tell them apart.
class FragileChoices : public Course<OnlineSelection> {
 public:
  FragileChoices() {
    std::mt19937 rng(5);
    const SE2 motion(1.0, 0.0, 2 * M_PI / kLap);
    for (int i = 0; i < 2 * kLap; ++i) noise_.push_back(motion * random_motion<SE2>(0.02, rng));
  }
  int steps() const override { return 2 * kLap; }
  void step(OnlineSelection& judge, int k) const override {
    Delta delta;
    if (k == 0) {
      add_origin(delta);
    } else {
      const SE2& z = noise_[k];
      const auto step = fragile(between(k - 1, k, z, 0.02));
      delta.values.insert(pose(k), judge.smoother().values().at<SE2>(pose(k - 1)) * z);
      if (k % 4 == 3) {
        const auto other = fragile(between(k - 1, k, z * SE2(0.4, 0.1 * k, 0.5), 0.02));
        delta.hybrid.push_back(std::make_shared<Mixture>(
            std::vector<DiscreteKey>{{Key('h', static_cast<std::uint64_t>(k)), 2}},
            std::vector<MixtureComponent>{{other, 0.0, false}, {step, 0.0, false}}));
      } else {
        delta.continuous.push_back(step);
      }
    }
    if (k >= kLap && k % 2 == 0) {
      delta.continuous.push_back(fragile(between(k - kLap, k, SE2(), 0.05)));
    }
    judge.update(delta);
  }

 private:
  static constexpr int kLap = 13;
  std::vector<SE2> noise_;
};

TEST(OnlineChoices, AFactorThatThrowsAnywhereLeavesItAsItWas) {
  EXPECT_GT(fail_everywhere(FragileChoices()), 300);
}

/// A judge for which closures wait, since two choices that are the same cannot be told apart.
OnlineSelection with_waiting_closures() {
  OnlineSelection judge;
  const auto step = [](int i) { return between(i, i + 1, SE2(1.0, 0.0, 0.0), 0.1); };
  Delta delta;
  for (int i = 0; i < 4; ++i) delta.values.insert(pose(i), SE2(i, 0.0, 0.0));
  delta.continuous = {std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.01)),
                      step(0), step(2)};
  delta.hybrid = {
      std::make_shared<Mixture>(std::vector<DiscreteKey>{{Key('h', 0), 2}},
                                std::vector<MixtureComponent>{{step(1), 0.0}, {step(1), 0.0}})};
  judge.update(delta);
  Delta closure;
  closure.continuous = {between(0, 3, SE2(3.1, 0.0, 0.0), 0.1)};
  judge.update(closure);
  EXPECT_EQ(judge.waiting(), 1u);
  return judge;
}

TEST(OnlineChoices, ASingularChangeLeavesItAsItWas) {
  OnlineSelection judge = with_waiting_closures();
  const std::vector<double> before = state_of(judge);
  Delta delta;  // of a pose that does not hang on the one before it, and is not determined
  delta.values.insert(pose(9), SE2());
  delta.continuous.push_back(
      std::make_shared<Position2>(pose(9), Eigen::Vector2d(1.0, 1.0), Noise::isotropic(2, 0.1)));
  const UpdateReport report = judge.update(delta);
  EXPECT_EQ(report.status, UpdateReport::Status::kSingular);
  EXPECT_NE(report.message.find("x9"), std::string::npos) << report.message;
  EXPECT_TRUE(report.handles.empty());
  EXPECT_EQ(state_of(judge), before);
  delta.continuous.push_back(
      std::make_shared<Prior<SE2>>(pose(9), SE2(), Noise::isotropic(3, 0.1)));
  EXPECT_EQ(judge.update(delta).status, UpdateReport::Status::kOk);
  EXPECT_EQ(judge.waiting(), 0u);
}

TEST(OnlineChoices, BadInputLeavesWhatWaitsAsItWas) {
  OnlineSelection judge = with_waiting_closures();
  const std::vector<double> before = state_of(judge);
  Delta bad;
  bad.values.insert(pose(0), SE2());  // is there already, and hangs on nothing
  EXPECT_THROW(judge.update(bad), Error);
  EXPECT_EQ(state_of(judge), before);
}

}  // namespace
}  // namespace hybrid
