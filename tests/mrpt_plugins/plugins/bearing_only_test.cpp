// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Many logs of bearings alone: every one gives a map, and the map keeps what it promises.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "libhybrid/core/chi_square.h"
#include "tests/mrpt_plugins/plugins/beacon_world.h"

namespace hybrid {
namespace {

using testing::BeaconWorld;

constexpr unsigned kSeeds = 100;
constexpr int kKeyframes = 40;
constexpr double kThreeSigma = 0.9973;  // probability of an interval of three sigmas to both sides

struct Counts {
  std::size_t placed = 0, off = 0, unusable = 0;
  double worst = 0;  // squared error by its covariance
};

Counts run(bool is_3d, double false_share) {
  Counts counts;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    BeaconWorld world(is_3d, seed);
    Mapper mapper = testing::make_mapper("BearingOnlyKnownIds", is_3d);
    for (int i = 0; i < kKeyframes; ++i) mapper.add(world.with_bearings(i, false_share));
    mapper.finish();
    counts.unusable += mapper.warnings().size();
    const MapResult result = mapper.result();
    EXPECT_EQ(result.trajectory.size(), static_cast<std::size_t>(kKeyframes)) << "seed " << seed;
    const int n = is_3d ? 3 : 2;
    for (const LandmarkEstimate& l : result.landmarks) {
      ++counts.placed;
      const Eigen::VectorXd error =
          (l.position - world.beacons.at(static_cast<std::size_t>(l.id))).head(n);
      const double square = error.dot(l.covariance.topLeftCorner(n, n).llt().solve(error));
      counts.worst = std::max(counts.worst, square);
      if (!(square < chi_square_quantile(kThreeSigma, n))) {
        ++counts.off;
      }
    }
  }
  return counts;
}

class BearingOnly : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(PlaneAndSpace, BearingOnly, ::testing::Bool());

TEST_P(BearingOnly, EveryLogGivesAMapThatKeepsItsPromises) {
  const Counts counts = run(GetParam(), 0);
  EXPECT_GT(counts.placed, 300U);
  EXPECT_EQ(counts.unusable, 0U);
  // Of 400 landmarks 1.1 are expected beyond three sigmas; 5 or more with a probability of 0.5 %.
  EXPECT_LE(counts.off, 4U);
  EXPECT_LT(counts.worst, 36);
}

TEST_P(BearingOnly, FalseBearingsEndNoRun) {
  for (double share : {0.1, 0.3}) {
    const Counts counts = run(GetParam(), share);
    EXPECT_EQ(counts.unusable, 0U);
    EXPECT_GT(counts.placed, 200U);
  }
}

/// The sensor takes one landmark for another at first.
TEST_P(BearingOnly, ALandmarkInTheWrongPlaceIsPlacedAgain) {
  BeaconWorld world(GetParam(), 3);
  Mapper mapper = testing::make_mapper("BearingOnlyKnownIds", GetParam());
  for (int i = 0; i < kKeyframes; ++i) {
    Keyframe keyframe = world.with_bearings(i);
    std::vector<Detection>& seen = keyframe.detections[0].detections;
    if (i < 12) {
      const std::int64_t id = seen[0].id.value();
      seen[0] = seen[3];
      seen[0].id = id;
    }
    mapper.add(keyframe);
    if (i == 11) {
      ASSERT_NE(mapper.landmarks().find(0), nullptr);
      const LandmarkEstimate early = mapper.result().landmarks.front();
      ASSERT_LT((early.position - world.beacons[3]).norm(), 1.0) << "not where it was to be";
    }
  }
  mapper.finish();
  const MapResult result = mapper.result();
  ASSERT_EQ(result.landmarks.size(), world.beacons.size());
  for (const LandmarkEstimate& l : result.landmarks) {
    EXPECT_LT((l.position - world.beacons.at(static_cast<std::size_t>(l.id))).norm(), 0.4) << l.id;
  }
}

}  // namespace
}  // namespace hybrid
