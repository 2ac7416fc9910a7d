// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/smoother/incremental.h"

namespace hybrid {
namespace {

// The motion is so much more certain than the place that pivots are lost in rounding, in the update
// that brings the variables and in later ones that bring none.
TEST(Determination, HoldsWherePivotsAreLostAndNothingIsNew) {
  for (const double sigma : {1e-7, 1e-8}) {
    IncrementalSmoother smoother;
    Delta delta;
    for (std::uint64_t i = 0; i < 4; ++i) {
      delta.values.insert(Key('x', i), SE2(static_cast<double>(i), 0.1, 0.3));
    }
    delta.continuous.push_back(
        std::make_shared<Prior<SE2>>(Key('x', 0), SE2(), Noise::isotropic(3, 1.0)));
    for (std::uint64_t i = 1; i < 4; ++i) {
      delta.continuous.push_back(std::make_shared<BetweenSE2>(
          Key('x', i - 1), Key('x', i), SE2(1, 0, 0.1), Noise::isotropic(3, sigma)));
    }
    if (smoother.update(delta).status != UpdateReport::Status::kOk) continue;
    EXPECT_EQ(smoother.converge().status, UpdateReport::Status::kOk) << sigma;
    EXPECT_EQ(smoother.update({}).status, UpdateReport::Status::kOk) << sigma;
    const Values& values = smoother.estimate().values;
    const SE2 motion = values.at<SE2>(Key('x', 0)).inverse() * values.at<SE2>(Key('x', 1));
    EXPECT_TRUE(motion.translation().isApprox(Eigen::Vector2d(1, 0), 1e-5)) << sigma;
  }
}

/// A chain whose motions are so certain that pivots are lost, every motion measured twice.
class TwiceMeasured : public ::testing::Test {
 protected:
  TwiceMeasured() {
    Delta delta;
    delta.values.insert(Key('x', 0), SE2());
    delta.continuous.push_back(
        std::make_shared<Prior<SE2>>(Key('x', 0), SE2(), Noise::isotropic(3, 1.0)));
    for (std::uint64_t i = 1; i < 30; ++i) {
      delta.values.insert(Key('x', i), delta.values.at<SE2>(Key('x', i - 1)) * motion_);
      for (int n = 0; n < 2; ++n) delta.continuous.push_back(between(i - 1, i));
    }
    const UpdateReport report = smoother_.update(delta);
    EXPECT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    handles_ = report.handles.all();
  }

  ContinuousFactorPtr between(std::uint64_t a, std::uint64_t b) const {
    return std::make_shared<BetweenSE2>(Key('x', a), Key('x', b), motion_,
                                        Noise::isotropic(3, 1e-7));
  }

  /// Adds a pose at the end, and removes a factor: number 0 is the prior, 2 i - 1 and 2 i are the
  /// motions to pose i.
  UpdateReport::Status without(std::size_t number) {
    Delta delta;
    const std::uint64_t last = smoother_.values().size() - 1;
    delta.values.insert(Key('x', last + 1), smoother_.values().at<SE2>(Key('x', last)) * motion_);
    delta.continuous.push_back(between(last, last + 1));
    delta.remove.push_back(handles_[number]);
    return smoother_.update(delta).status;
  }

  SE2 motion_ = SE2(1, 0, 0.01);
  IncrementalSmoother smoother_;
  std::vector<Handle> handles_;
};

TEST_F(TwiceMeasured, WhatOthersSayMayGo) {
  for (const std::size_t number : {2u, 21u, 57u}) {
    EXPECT_EQ(without(number), UpdateReport::Status::kOk) << number;
  }
}

TEST_F(TwiceMeasured, WhatNothingElseSaysIsMissed) {
  EXPECT_EQ(without(0), UpdateReport::Status::kSingular);
  EXPECT_EQ(without(21), UpdateReport::Status::kOk);
  EXPECT_EQ(without(22), UpdateReport::Status::kSingular);  // the other one of this motion
  EXPECT_EQ(without(23), UpdateReport::Status::kOk);
}

TEST_F(TwiceMeasured, WhatGoesWithAllItsFactorsIsNotMissed) {
  Delta alone;
  const Key key('b', 0);
  alone.values.insert(key, Eigen::Vector2d(1, 2));
  alone.continuous.push_back(std::make_shared<Prior<Eigen::Vector2d>>(key, Eigen::Vector2d(1, 2),
                                                                      Noise::isotropic(2, 1.0)));
  const UpdateReport report = smoother_.update(alone);
  ASSERT_EQ(report.status, UpdateReport::Status::kOk);
  Delta delta;
  delta.remove = report.handles.all();
  delta.remove_values = {key};
  delta.values.insert(Key('x', 30), smoother_.values().at<SE2>(Key('x', 29)) * motion_);
  delta.continuous.push_back(between(29, 30));
  EXPECT_EQ(smoother_.update(delta).status, UpdateReport::Status::kOk);
}

}  // namespace
}  // namespace hybrid
