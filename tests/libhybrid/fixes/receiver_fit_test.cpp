// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/fixes/receiver_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hybrid {
namespace {

/// What a receiver on a car is really like.
struct Receiver {
  double own = 0.5, good = 2, lasts = 60;  // m, m, s
  double share_false = 0.01;
  double delay = 0;     // s
  double odometry = 1;  // its noise is so many times that stated
  int every = 150;      // s between runs of biased fixes
};

/// Some minutes of a car at 8 m/s that turns now and then, with a fix each second.
std::vector<MovedFix> drive(const Receiver& truth, unsigned seed, int seconds) {
  std::mt19937 random(seed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> uniform;
  const auto both = [&](double sigma) {
    const double x = sigma * gauss(random);
    return Eigen::Vector2d(x, sigma * gauss(random));
  };
  constexpr double kSpeed = 8, kAlong = 0.05, kTurn = 0.01;
  std::vector<MovedFix> out;
  SE2 pose(300, -200, 2 * uniform(random));
  Eigen::Vector2d error = both(truth.good), bias(0, 0);
  const double kept = std::exp(-1 / truth.lasts);
  int biased = 0;
  for (int i = 0; i < seconds; ++i) {
    const double turn = i / 20 % 3 == 1 ? 0.08 : i / 20 % 3 == 2 ? -0.06 : 0;
    const SE2 moved = SE2::exp({kSpeed, 0, turn});
    pose = pose * moved;
    error = kept * error + both(truth.good * std::sqrt(1 - kept * kept));
    if (biased > 0 && --biased == 0) bias.setZero();
    if (biased == 0 && uniform(random) * truth.every < 1) {
      biased = 20;
      bias = both(12);
    }
    MovedFix fix;
    fix.time = 1000 + i;
    fix.antenna = Eigen::Vector2d(1, 0.5);
    fix.velocity = Eigen::Vector2d(kSpeed, 0);
    const Eigen::Vector2d earlier = fix.antenna - truth.delay * fix.velocity;
    fix.position = pose * earlier + error + bias + both(truth.own);
    if (uniform(random) < truth.share_false) fix.position += both(300);
    fix.sigma = 2;
    const double noise = truth.odometry;
    fix.motion = moved * SE2(noise * kAlong * gauss(random), noise * kAlong * gauss(random),
                             noise * kTurn * gauss(random));
    fix.covariance = Eigen::Vector3d(kAlong * kAlong, kAlong * kAlong, kTurn * kTurn).asDiagonal();
    fix.begins = i == 0;
    out.push_back(fix);
  }
  return out;
}

/// The fits of a few drives, of which one parameter counts.
template <class Parameter>
double median_of(const Receiver& truth, const Parameter& parameter) {
  std::vector<double> found;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const ReceiverFit fit = fit_receiver(drive(truth, seed, 600), FixModel());
    EXPECT_TRUE(fit.is_known);
    found.push_back(parameter(fit));
  }
  std::sort(found.begin(), found.end());
  return found[1];
}

TEST(ReceiverFit, FindsTheNoiseOfAReceiver) {
  Receiver truth;
  for (const double own : {0.2, 1.0}) {
    truth.own = own;
    EXPECT_NEAR(median_of(truth, [](const auto& f) { return f.model.own_sigma; }), own, 0.15 * own);
  }
  truth = {};
  for (const double good : {1.0, 5.0}) {
    truth.good = good;
    const double found = median_of(truth, [](const auto& f) { return 2 * f.sigma_factor; });
    EXPECT_GT(found, 0.5 * good);
    EXPECT_LT(found, 1.6 * good);
  }
}

TEST(ReceiverFit, FindsTheNoiseOfTheOdometry) {
  Receiver truth;
  for (const double noise : {0.1, 1.0, 5.0}) {
    truth.odometry = noise;
    const double found = median_of(truth, [](const auto& f) { return f.rotation; });
    EXPECT_GT(found, noise / 1.5);
    EXPECT_LT(found, noise * 1.5);
  }
}

TEST(ReceiverFit, FindsALateClock) {
  Receiver truth;
  for (const double delay : {-0.4, 0.0, 0.4}) {
    truth.delay = delay;
    EXPECT_NEAR(median_of(truth, [](const auto& f) { return f.delay; }), delay, 0.1);
  }
}

// Along gentle turns a delay is hardly other than an antenna farther back.
TEST(ReceiverFit, FindsNoDelayOfWhichFixesAreNotSure) {
  Receiver truth;
  truth.own = 0.02;
  truth.share_false = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::vector<MovedFix> fixes = drive(truth, seed, 120);
    for (MovedFix& fix : fixes) fix.sigma = 0.02;
    EXPECT_LT(std::abs(fit_receiver(fixes, FixModel()).delay), 0.02) << seed;
  }
}

TEST(ReceiverFit, FindsHowOftenFixesAreBiasedOrFalse) {
  Receiver often, never;
  often.every = 40;
  often.share_false = 0.1;
  never.every = 1000000000;
  never.share_false = 0;
  const auto runs = [](const auto& f) { return f.model.good_lasts; };
  const auto wrong = [](const auto& f) { return f.model.false_share; };
  EXPECT_LT(median_of(often, runs), 0.5 * median_of(never, runs));
  EXPECT_NEAR(median_of(often, wrong), 0.1, 0.04);
  EXPECT_LT(median_of(never, wrong), 0.01);
}

TEST(ReceiverFit, OfAReceiverThatStandsOrOfFewFixesNothingIsKnown) {
  std::vector<MovedFix> few = drive({}, 1, 20);
  EXPECT_FALSE(fit_receiver(few, FixModel()).is_known);
  std::vector<MovedFix> standing = drive({}, 1, 200);
  for (MovedFix& fix : standing) {
    fix.motion = SE2();
    fix.position = Eigen::Vector2d(5, 5);
  }
  EXPECT_FALSE(fit_receiver(standing, FixModel()).is_known);
  EXPECT_FALSE(fit_receiver({}, FixModel()).is_known);
}

}  // namespace
}  // namespace hybrid
