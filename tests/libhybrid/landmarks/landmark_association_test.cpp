// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/landmarks/landmark_association.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/motion_covariance.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/smoother/proposal.h"

namespace hybrid {
namespace {

constexpr int kSteps = 90;

/// Holds the graph of an association, and turns down what is on trial as it is told to.
struct TrialHost {
  enum class Verdict { kByTheMap, kNever, kImpossible };

  explicit TrialHost(Verdict verdict) : verdict_(verdict) {}

  void add(const SE2& motion, const Noise& noise, const DetectionFrame& seen) {
    const auto i = static_cast<std::uint64_t>(keyframes++);
    const Key now(key_letter::kPose, i);
    SE2 place = motion;
    ContinuousFactorPtr factor = std::make_shared<Prior<SE2>>(now, motion, noise);
    if (i > 0) {
      const Key before(key_letter::kPose, i - 1);
      place = map.values().at<SE2>(before) * motion;
      factor = std::make_shared<BetweenSE2>(before, now, motion, noise);
    }
    Delta delta;
    delta.continuous.push_back(factor);
    delta.values.insert(now, place);
    MapView seen_before = view();
    const auto covariance = seen_before.covariance_of;
    seen_before.joint_covariance = [&](const std::vector<Key>& keys) {
      return covariance_after_motion(*factor, delta.values, map.values(), covariance, keys);
    };
    const std::vector<DetectionFrame> frames = {seen};
    const Contribution out = association.observe({now, to_isometry(place), frames}, seen_before);
    map.update(delta);
    apply(out);
    change_until_done([this] { return association.revise(view()); });
  }
  void finish() {
    change_until_done([this] { return association.conclude(view()); });
  }

  double statistic(const char* name) const {
    const auto all = association.statistics();
    const auto it = all.find(name);
    return it == all.end() ? 0 : it->second;
  }

  MapView view() const {
    MapView out{map.values(), map.assignment(), landmarks, false};
    out.holds = [this](Key key) { return map.values().contains(key); };
    out.joint_covariance = [this](const std::vector<Key>& keys) {
      return map.joint_covariance(keys);
    };
    out.covariance_of = [this](const std::vector<Key>& keys, const Eigen::MatrixXd& J) {
      return map.joint_covariance(keys, J);
    };
    return out;
  }

  IncrementalSmoother map;
  LandmarkRegistry landmarks;
  LandmarkAssociation association{AssociationOptions{}, ClassModel{}};
  int keyframes = 0, proposals = 0;

 private:
  template <class Next>
  void change_until_done(const Next& next) {
    for (Contribution change = next(); !change.empty(); change = next()) apply(change);
  }
  void apply(const Contribution& change) {
    enter(change, landmarks);
    const double before = map.objective();
    UpdateReport report;
    if (change.allowed_rise) {
      ++proposals;
      const double allowed = verdict_ == Verdict::kByTheMap ? *change.allowed_rise
                                                            : -std::numeric_limits<double>::max();
      Delta delta = change.delta;
      if (verdict_ == Verdict::kImpossible) {  // leaves a variable undetermined
        delta.values.insert(Key(key_letter::kPose, 1000000), SE2());
      }
      report = propose(map, {delta, allowed});
    } else {
      report = map.update(change.delta);
    }
    if (report.status != UpdateReport::Status::kOk) {
      landmarks.roll_back();
      association.refused();
      return;
    }
    landmarks.commit();
    if (change.settle) map.settle();
    association.applied({report.handles, before, map.objective(), report.exact});
  }

  Verdict verdict_;
};

/// Where the robot is at a step: on a circle, on which it comes back to where it began.
SE2 place(int i) {
  const double a = 2 * M_PI * i / (kSteps - 12);
  return {12 * std::sin(a), 12 * (1 - std::cos(a)), a};
}

/// A round among posts, with so much drift that they are made anew when they are seen again.
void drive_round(unsigned seed, TrialHost& host) {
  std::mt19937 random(seed);
  const auto noisy = [&](double sigma) {
    return sigma * std::normal_distribution<double>()(random);
  };
  const std::vector<Eigen::Vector2d> posts = {{0.5, 3.1},  {2.4, -2.2}, {4.0, 1.2}, {5.1, -1.0},
                                              {-1.8, 1.5}, {12, 9},     {8, 14},    {-9, 9}};
  for (int i = 0; i < kSteps; ++i) {
    DetectionFrame seen;
    seen.is_3d = false;
    seen.max_range = 6;
    seen.fov_yaw = 2 * M_PI;
    for (std::size_t k = 0; k < posts.size(); ++k) {
      const Eigen::Vector2d z = to_polar(Eigen::Vector2d(place(i).inverse() * posts[k]));
      if (z[0] > seen.max_range) continue;
      Detection d;
      d.range = z[0] + noisy(0.03);
      d.yaw = z[1] + noisy(0.01);
      d.covariance.diagonal() << 9e-4, 1e-4, 0;
      d.true_id = static_cast<std::int64_t>(k);
      seen.detections.push_back(d);
    }
    const SE2 motion =
        i == 0 ? SE2()
               : place(i - 1).between(place(i)) * SE2(noisy(0.06), noisy(0.06), noisy(0.02));
    const double scale = i == 0 ? 0.01 : 1;
    host.add(motion, Noise::diagonal(scale * Eigen::Vector3d(0.06, 0.06, 0.02)), seen);
  }
  host.finish();
}

std::vector<std::int64_t> landmark_of_each(const TrialHost& host) {
  std::vector<std::int64_t> out;
  for (const AssociationDecision& d : host.association.decisions(host.view()))
    out.push_back(d.estimated_id.value_or(-1));
  return out;
}

// As the map says: what it bears out is kept.
TEST(LandmarkAssociation, MergesWhatTheMapBearsOut) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    TrialHost host(TrialHost::Verdict::kByTheMap);
    drive_round(seed, host);
    EXPECT_GT(host.proposals, 0);
    EXPECT_GT(host.statistic("landmarks_merged"), 0);
    EXPECT_LE(host.landmarks.size(), 8U);
    const SE2 last = host.map.values().at<SE2>(Key(key_letter::kPose, kSteps - 1));
    EXPECT_LT((last.translation() - place(kSteps - 1).translation()).norm(), 0.5);
  }
}

// Whether the objective speaks against it or it is not possible at all: what belongs to what, the
// landmarks and the map are the same as if it had not been proposed, and it is not tried for ever.
TEST(LandmarkAssociation, IsAsBeforeWhereAMergeIsTurnedDown) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    TrialHost never(TrialHost::Verdict::kNever), impossible(TrialHost::Verdict::kImpossible);
    drive_round(seed, never);
    drive_round(seed, impossible);
    EXPECT_GT(never.proposals, 0);
    EXPECT_EQ(never.statistic("merges_taken_back"), never.proposals);
    EXPECT_EQ(never.statistic("landmarks_merged"), 0);
    EXPECT_EQ(never.statistic("loops_closed"), 0);
    EXPECT_EQ(never.proposals, impossible.proposals);
    EXPECT_EQ(landmark_of_each(never), landmark_of_each(impossible));
    ASSERT_EQ(never.landmarks.size(), impossible.landmarks.size());
    std::map<std::int64_t, int> seen;
    for (const std::int64_t id : landmark_of_each(never)) ++seen[id];
    for (const auto& [id, landmark] : never.landmarks) {
      EXPECT_EQ(landmark.sightings, seen[id]);
      EXPECT_TRUE(never.map.values().contains(landmark.position));
      // Each sighting has its factor, and the class has none here.
      EXPECT_EQ(never.map.factors_of(landmark.position).size(), std::size_t(seen[id]));
    }
    EXPECT_EQ(never.map.objective(), impossible.map.objective());
  }
}

}  // namespace
}  // namespace hybrid
