// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/expect_jacobians.h"
#include "libhybrid/factors/motion_covariance.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/fixes/biased_position.h"
#include "libhybrid/fixes/datum_alignment.h"
#include "libhybrid/fixes/fix_mapper.h"
#include "libhybrid/fixes/map_shift.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/smoother/window.h"

namespace hybrid {
namespace {

TEST(BiasedPosition, JacobiansAreThoseOfDifferences) {
  const Key x('x', 0), e('e', 0);
  Values plane, space;
  plane.insert(x, SE2(3, -2, 0.7));
  plane.insert(e, Eigen::Vector2d(0.3, -1.2));
  testing::expect_jacobians(BiasedPosition<SE2>(x, e, {4, 5}, Noise::isotropic(2, 0.5), {1, -0.4}),
                            plane);
  space.insert(x, SE3(Eigen::Vector3d(1, 2, 3), SO3::exp({0.1, -0.2, 0.9})));
  space.insert(e, Eigen::Vector3d(0.3, -1.2, 2));
  testing::expect_jacobians(
      BiasedPosition<SE3>(x, e, {4, 5, 6}, Noise::isotropic(3, 0.5), {1, -0.4, 0.2}), space);
}

TEST(FixModel, WhatFollowsAModeIsOneOfTheOthers) {
  const FixModel model;
  for (const double time : {0.2, 1.0, 30.0}) {
    for (int from = 0; from < kErrorModes; ++from) {
      const auto before = static_cast<ErrorMode>(from);
      double sum = 0;
      for (int to = 0; to < kErrorModes; ++to) {
        sum += std::exp(-mode_cost(model, &before, static_cast<ErrorMode>(to), time));
      }
      EXPECT_NEAR(sum, 1, 1e-12);
    }
  }
}

TEST(DatumAlignment, OneThirdOfThePairsMayBeFalse) {
  std::mt19937 random(3);
  std::normal_distribution<double> gauss;
  const Eigen::Isometry3d T =
      Eigen::Translation3d(500, -80, 12) * Eigen::AngleAxisd(2.5, Eigen::Vector3d::UnitZ());
  std::vector<DatumPair> pairs;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d p(i, 8 * std::sin(0.1 * i), 0);
    Eigen::Vector3d z = T * p + Eigen::Vector3d(gauss(random), gauss(random), 0);
    if (i % 3 == 0) z += Eigen::Vector3d(100 * gauss(random), 100 * gauss(random), 0);
    pairs.push_back({p, z, 1});
  }
  const auto found = align_to_datum(pairs, 0.1);
  ASSERT_TRUE(found);
  EXPECT_NEAR(std::atan2(found->linear()(1, 0), found->linear()(0, 0)), 2.5, 0.05);
  EXPECT_LT((*found * pairs[30].in_map - T * pairs[30].in_map).norm(), 1);
}

TEST(DatumAlignment, ManyPairsTellThatTheirSigmasAreTooLarge) {
  std::vector<DatumPair> pairs;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d p(i, 8 * std::sin(0.1 * i), 0);
    pairs.push_back({p, p + Eigen::Vector3d(7, 8, 0), 100});
  }
  const auto found = align_to_datum(pairs, 0.1);
  ASSERT_TRUE(found);
  EXPECT_LT((found->translation() - Eigen::Vector3d(7, 8, 0)).norm(), 1e-6);
  pairs.resize(30);
  EXPECT_FALSE(align_to_datum(pairs, 0.1));
}

TEST(DatumAlignment, AFewGoodFixesOnASmallFieldTellIt) {
  std::mt19937 random(3);
  std::normal_distribution<double> gauss(0, 0.1);
  std::vector<DatumPair> pairs;
  for (int i = 0; i < 29; ++i) {
    const Eigen::Vector3d p(12 * std::cos(0.7 * i), 7 * std::sin(0.7 * i), 0);
    pairs.push_back({p, p + Eigen::Vector3d(gauss(random), gauss(random), 0), 2});
  }
  const auto found = align_to_datum(pairs, 0.1);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->linear()(1, 0), 0, 0.02);
  pairs.resize(3);
  EXPECT_FALSE(align_to_datum(pairs, 0.1));
}

TEST(DatumAlignment, AShortPathOrContradictionsTellNothing) {
  std::vector<DatumPair> pairs;
  for (int i = 0; i < 60; ++i) pairs.push_back({{0.01 * i, 0, 0}, {0.01 * i, 0, 0}, 1});
  EXPECT_FALSE(align_to_datum(pairs, 0.1));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(-1000, 1000);
  for (int i = 0; i < 60; ++i) {
    pairs[static_cast<std::size_t>(i)] = {
        {1.0 * i, 0, 0}, {anywhere(random), anywhere(random), 0}, 1};
  }
  EXPECT_FALSE(align_to_datum(pairs, 0.1));
}

/// A robot that drives in circles with odometry and fixes.
class Drive {
 public:
  explicit Drive(unsigned seed, const FixModel& model = {}) : random_(seed), fixes_(model) {}

  double gauss(double sigma) { return sigma * std::normal_distribution<double>()(random_); }

  SE2 truth(int i) const {
    const double a = 0.02 * i;
    return {40 * std::sin(a), 40 - 40 * std::cos(a), a};
  }

  /// One keyframe with a fix of each receiver, that are off by `errors`.
  void step(const std::vector<Eigen::Vector2d>& errors) {
    const Key now(key_letter::kPose, static_cast<std::uint64_t>(steps_));
    Delta delta;
    ContinuousFactorPtr motion;
    SE2 at;
    if (steps_ == 0) {
      motion = std::make_shared<Prior<SE2>>(now, SE2(), Noise::isotropic(3, 1e-3));
    } else {
      const Key before(key_letter::kPose, static_cast<std::uint64_t>(steps_ - 1));
      const SE2 moved =
          truth(steps_ - 1).between(truth(steps_)) * SE2(gauss(0.02), gauss(0.02), gauss(0.002));
      motion = std::make_shared<BetweenSE2>(before, now, moved,
                                            Noise::diagonal(Eigen::Vector3d(0.02, 0.02, 0.002)));
      at = smoother_.smoother().values().at<SE2>(before) * moved;
    }
    delta.values.insert(now, at);
    delta.continuous.push_back(motion);
    const Values& values = smoother_.smoother().values();
    const CovarianceOf covariance = [this](const std::vector<Key>& keys, const Eigen::MatrixXd& J) {
      return Eigen::MatrixXd(J * smoother_.smoother().joint_covariance(keys) * J.transpose());
    };
    const LandmarkRegistry none;
    MapView map{values, smoother_.smoother().assignment(), none};
    map.holds = [&](Key key) { return values.contains(key); };
    const MotionCovariance after(*motion, now, delta.values, values, covariance);
    KeyframeView frame{now, isometry_at(delta.values, now), {}, after, after};
    std::vector<Fix> fixes(errors.size());
    for (std::size_t i = 0; i < errors.size(); ++i) {
      Fix& fix = fixes[i];
      fix.sensor = std::to_string(i);
      fix.time = steps_;
      fix.sigma = 1;
      const SE2 T_datum_map(700, -300, 1.2);
      const Eigen::Vector2d antenna(0.5, 0.1);
      fix.antenna << antenna, 1;
      fix.position << T_datum_map * (truth(steps_) * antenna) + errors[i], 0;
    }
    const Contribution c = fixes_.observe(frame, fixes, map);
    for (const auto& f : c.delta.continuous) delta.continuous.push_back(f);
    for (const auto& f : c.delta.hybrid) delta.hybrid.push_back(f);
    for (const auto& f : c.delta.discrete) delta.discrete.push_back(f);
    for (const Key key : c.delta.values.keys()) {
      delta.values.insert(key, c.delta.values.type(key), c.delta.values.data(key));
    }
    for (const auto& [key, value] : c.delta.assignment) delta.assignment.set(key, value);
    const WindowReport report = smoother_.update(delta);
    if (steps_ == 0) origin_ = report.handles.continuous.front();
    ++steps_;
    if (fixes_.find_datum(map)) {
      Delta freed;
      freed.remove = {origin_};
      freed.continuous = {
          std::make_shared<Prior<SE2>>(Key(key_letter::kPose, 0), SE2(), Noise::isotropic(3, 100))};
      smoother_.update(freed);
    }
    const Contribution late = fixes_.revise(map);
    if (late.allowed_rise) {
      const Proposal moved{late.delta, *late.allowed_rise, late.moved};
      if (smoother_.propose(moved).status != UpdateReport::Status::kOk) fixes_.refused();
    } else if (!late.empty()) {
      smoother_.update(late.delta);
    }
  }

  /// Mode of a fix: 0 good, 1 biased, 2 false, -1 not in the map.
  int mode(int i) const {
    const FixEntry& entry = fixes_.fixes()[static_cast<std::size_t>(i)];
    const Assignment& chosen = smoother_.smoother().assignment();
    if (!entry.falsity) return -1;
    if (chosen.at(*entry.falsity) == 1) return 2;
    return is_biased(static_cast<ErrorMode>(chosen.at(entry.mode.key))) ? 1 : 0;
  }
  /// Of the position in the axes of the datum [m].
  double error(int i) const {
    const Key key(key_letter::kPose, static_cast<std::uint64_t>(i));
    const Eigen::Isometry3d T = *fixes_.datum() * isometry_at(smoother_.smoother().values(), key);
    return (T.translation().head<2>() - SE2(700, -300, 1.2) * truth(i).translation()).norm();
  }

 private:
  std::mt19937 random_;
  FixMapper fixes_;
  WindowSmoother smoother_;
  Handle origin_;
  int steps_ = 0;
};

TEST(PosesAtFixes, TwoAntennasTellTheHeading) {
  const SE2 T_datum_map(100, 50, 0);
  std::vector<FixEntry> fixes;
  std::vector<SE2> truth;
  for (int i = 0; i < 20; ++i) {
    truth.emplace_back(2 * i, 0.1 * i * i, 2.5 + 0.05 * i);
    for (const Eigen::Vector2d& antenna : {Eigen::Vector2d(0.5, 0.6), Eigen::Vector2d(0.5, -0.6)}) {
      FixEntry entry;
      entry.pose = Key(key_letter::kPose, static_cast<std::uint64_t>(i));
      entry.fix.antenna << antenna, 1;
      entry.fix.position << T_datum_map * (truth.back() * antenna), 1;
      entry.fix.sensor = antenna.y() > 0 ? "left" : "right";
      fixes.push_back(entry);
    }
    // A receiver that is off tells nothing.
    if (i % 5 != 0) continue;
    FixEntry wrong = fixes.back();
    wrong.fix.sensor = "far";
    wrong.fix.position += Eigen::Vector3d(100, 0, 0);
    fixes.insert(fixes.end() - 2, wrong);
  }
  const Values poses = poses_at_fixes(fixes, to_isometry(T_datum_map), false);
  ASSERT_EQ(poses.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const SE2 pose = poses.at<SE2>(Key(key_letter::kPose, i));
    EXPECT_LT(truth[i].between(pose).log().norm(), 1e-9) << i;
  }
}

TEST(FixMapper, RunsOfBiasedFixesAndFalseOnesAreFound) {
  Drive drive(1);
  std::vector<int> truth;
  for (int i = 0; i < 400; ++i) {
    const bool biased = i >= 200 && i < 230, wrong = i % 37 == 5;
    Eigen::Vector2d error(drive.gauss(0.3), drive.gauss(0.3));
    if (biased) error += Eigen::Vector2d(9, -6);
    if (wrong) error += Eigen::Vector2d(120, 80);
    truth.push_back(wrong ? 2 : biased ? 1 : 0);
    drive.step({error});
  }
  int right = 0, seen = 0;
  for (int i = 0; i < 400; ++i) {
    if (drive.mode(i) < 0) continue;
    ++seen;
    right += drive.mode(i) == truth[static_cast<std::size_t>(i)];
  }
  EXPECT_EQ(seen, 400);
  EXPECT_GE(right, 396);
  double worst = 0;
  for (int i = 0; i < 400; ++i) worst = std::max(worst, drive.error(i));
  EXPECT_LT(worst, 1.5);  // sigma of good fixes is 1 m, of which the path averages few
}

TEST(FixMapper, EachReceiverHasErrorsOfItsOwn) {
  Drive drive(1);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector2d good(drive.gauss(0.3), drive.gauss(0.3));
    drive.step({good, Eigen::Vector2d(9 + drive.gauss(0.3), drive.gauss(0.3) - 6),
                Eigen::Vector2d(drive.gauss(0.3), drive.gauss(0.3))});
  }
  int right = 0;
  for (int i = 0; i < 900; ++i) right += drive.mode(i) == (i % 3 == 1 ? 1 : 0);
  EXPECT_GE(right, 880);
  EXPECT_LT(drive.error(299), 1.5);
}

TEST(FixMapper, AMapThatBeginsAtABiasIsPutRight) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Drive drive(seed);
    for (int i = 0; i < 400; ++i) {
      Eigen::Vector2d error(drive.gauss(0.3), drive.gauss(0.3));
      if (i >= 4 && i < 60) error += Eigen::Vector2d(9, 4);
      drive.step({error});
    }
    EXPECT_EQ(drive.mode(30), 1);
    EXPECT_EQ(drive.mode(300), 0);
    EXPECT_LT(drive.error(399), 1.5) << "seed " << seed;
  }
}

}  // namespace
}  // namespace hybrid
