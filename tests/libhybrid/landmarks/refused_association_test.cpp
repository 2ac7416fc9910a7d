// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "libhybrid/geometry/polar.h"
#include "tests/libhybrid/landmarks/trial_host.h"

namespace hybrid {
namespace {

using testing::TrialHost;

/// A keyframe of a log, and what is refused before it.
struct LogStep {
  SE2 motion;
  Noise noise = Noise::isotropic(3, 1);
  std::vector<DetectionFrame> seen, refused;
};

/// A robot with two sensors that goes round among posts, two of which have an id, and a walker
/// ahead.
class PostLog {
 public:
  explicit PostLog(unsigned seed) : random_(seed) {
    for (int k = 0; k < 14; ++k) posts_.emplace_back(uniform(-4, 16), uniform(-4, 16));
    for (int i = 0; i < kSteps; ++i) steps.push_back(step(i));
  }
  std::vector<LogStep> steps;

 private:
  static constexpr int kSteps = 60;

  double uniform(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }
  double noisy(double sigma) { return sigma * std::normal_distribution<double>()(random_); }

  static SE2 place(int i) {
    const double a = 2 * M_PI * i / (kSteps - 10);
    return {6 + 6 * std::sin(a), 6 - 6 * std::cos(a), a};
  }
  Detection detection(const Eigen::Vector2d& z, double sigma, bool is_tree) {
    Detection d;
    d.range = std::abs(z[0] + noisy(sigma));
    d.yaw = z[1] + noisy(sigma / 3);
    d.covariance.diagonal() << sigma * sigma, sigma * sigma / 9, 0;
    d.class_probabilities = {is_tree ? 0.8 : 0.2, is_tree ? 0.2 : 0.8};
    return d;
  }
  DetectionFrame look(int i, const std::string& label, double max_range, double sigma) {
    DetectionFrame out;
    out.time = 0.5 * i;
    out.sensor_label = label;
    out.is_3d = false;
    out.max_range = max_range;
    out.fov_yaw = 2 * M_PI;
    out.class_names = {"tree", "pole"};
    std::vector<Eigen::Vector2d> things = posts_;
    things.emplace_back(place(i) * Eigen::Vector2d(2.5, 1.5 * std::sin(0.2 * i)));  // the walker
    for (std::size_t k = 0; k < things.size(); ++k) {
      const Eigen::Vector2d z = to_polar(Eigen::Vector2d(place(i).inverse() * things[k]));
      if (z[0] > max_range || random_() % 6 == 0) continue;
      out.detections.push_back(detection(z, sigma, k % 2 == 0));
      if (k < 2) out.detections.back().id = static_cast<std::int64_t>(k);
    }
    return out;
  }
  /// What makes little sense: far clutter, ids of others, a sensor that was never seen.
  std::vector<DetectionFrame> nonsense(int i) {
    std::vector<DetectionFrame> out = {look(i, "near", 5, 0.3), look(i, "third", 12, 0.05)};
    for (int k = 0; k < 8; ++k) {
      out[0].detections.push_back(detection({uniform(1, 11), uniform(-3, 3)}, 0.1, true));
    }
    for (DetectionFrame& frame : out) {
      frame.max_range *= 2;
      for (Detection& d : frame.detections) {
        if (random_() % 5 == 0) d.id = static_cast<std::int64_t>(random_() % 4);
      }
    }
    if (random_() % 4 == 0) out[1].class_names[0] = "dog";  // of which nothing is known
    return out;
  }
  LogStep step(int i) {
    LogStep out;
    if (i > 0) {
      out.motion = place(i - 1).between(place(i)) * SE2(noisy(0.05), noisy(0.05), noisy(0.02));
    } else {
      out.motion = place(0);
    }
    out.noise = Noise::diagonal((i > 0 ? 1 : 0.01) * Eigen::Vector3d(0.05, 0.05, 0.02));
    out.seen = {look(i, "near", 5, 0.05)};
    if (i % 3 == 0) out.seen.push_back(look(i, "far", 9, 0.1));
    if (i % 2 == 1) out.refused = nonsense(i);
    return out;
  }

  std::mt19937 random_;
  std::vector<Eigen::Vector2d> posts_;
};

ClassModel trees_and_poles() {
  ClassOptions options;
  options.names = {"tree", "pole"};
  return ClassModel(options);
}

auto decided(const TrialHost& host) {
  std::vector<std::tuple<std::int64_t, std::int64_t>> out;
  for (const AssociationDecision& d : host.association.decisions(host.view())) {
    out.emplace_back(d.estimated_id.value_or(-1), d.mover.value_or(-1));
  }
  return out;
}

auto moving(const TrialHost& host) {
  std::vector<std::tuple<std::int64_t, double, int>> out;
  for (const Mover& m : host.association.movers({0, 5, 10, 15}, host.view())) {
    out.emplace_back(m.id, m.probability, m.sightings);
  }
  return out;
}

void expect_same(const TrialHost& a, const TrialHost& b) {
  ASSERT_EQ(decided(a), decided(b));
  ASSERT_EQ(a.association.existence(), b.association.existence());
  ASSERT_EQ(a.association.statistics(), b.association.statistics());
  ASSERT_EQ(moving(a), moving(b));
  ASSERT_EQ(a.map.objective(), b.map.objective());
  ASSERT_EQ(a.landmarks.size(), b.landmarks.size());
  for (auto i = a.landmarks.begin(), j = b.landmarks.begin(); i != a.landmarks.end(); ++i, ++j) {
    ASSERT_EQ(i->first, j->first);
    ASSERT_EQ(i->second.sightings, j->second.sightings);
    ASSERT_EQ(i->second.position, j->second.position);
  }
}

// To the bit: decisions, odds, ids, movers and the map are those of a log without the keyframes
// that were refused, whether these were possible or made no sense.
TEST(RefusedAssociation, ARefusedKeyframeLeavesNothing) {
  int thrown = 0, movers = 0;
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    const PostLog log(seed);
    TrialHost without(TrialHost::Verdict::kByTheMap, trees_and_poles()), with = without;
    for (const LogStep& step : log.steps) {
      without.add(step.motion, step.noise, step.seen);
      with.add(step.motion, step.noise, step.seen, step.refused);
      expect_same(with, without);
      if (HasFatalFailure()) FAIL() << "seed " << seed << ", keyframe " << with.keyframes - 1;
    }
    with.finish();
    without.finish();
    expect_same(with, without);
    EXPECT_GT(without.landmarks.size(), 8U);
    thrown += with.thrown;
    movers += static_cast<int>(moving(with).size());
  }
  EXPECT_GT(thrown, 4);
  EXPECT_GT(movers, 0);
}

// Where no contribution waits for an answer there is nothing to go back to.
TEST(RefusedAssociation, WhatIsAnsweredStays) {
  const PostLog log(5);
  TrialHost host(TrialHost::Verdict::kByTheMap, trees_and_poles()), other = host;
  for (const LogStep& step : log.steps) {
    host.add(step.motion, step.noise, step.seen);
    other.add(step.motion, step.noise, step.seen);
    host.association.refused();
  }
  expect_same(host, other);
}

}  // namespace
}  // namespace hybrid
