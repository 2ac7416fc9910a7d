// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/landmarks/landmark_association.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/geometry/polar.h"
#include "tests/libhybrid/landmarks/trial_host.h"

namespace hybrid {
namespace {

constexpr int kSteps = 90;

using testing::TrialHost;

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
    host.add(motion, Noise::diagonal(scale * Eigen::Vector3d(0.06, 0.06, 0.02)), {seen});
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
