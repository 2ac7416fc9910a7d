// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/evidence.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/surface_match.h"

namespace hybrid {
namespace {

constexpr double kSigma = 0.1, kTurnSigma = 0.02, kSpread = 20.0;  // m, rad, m
const Key kFrom{key_letter::kPose, 0}, kTo{key_letter::kPose, 1};

Noise noise() {
  return Noise::covariance(
      Eigen::Vector3d(kSigma * kSigma, kSigma * kSigma, kTurnSigma * kTurnSigma).asDiagonal());
}

SurfaceMatch<SE2> match(double spread) {
  return {kFrom, kTo, SE2(1.0, 2.0, 0.3), noise(), spread * spread * Eigen::Matrix2d::Identity()};
}

EvidenceModel model() {
  EvidenceModel model;
  model.radius = 30.0;
  return model;
}

// Where a match fits exactly, both densities are at their peaks: their ratio is that of the roots
// of the determinants of their covariances, and the turn, which a false one has too, tells nothing.
TEST(Evidence, OfAMatchThatFitsIsHowFarItMightBeElsewhere) {
  const double ratio =
      model().log_ratio(Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity(), match(kSpread));
  EXPECT_NEAR(ratio, std::log1p(kSpread * kSpread / (kSigma * kSigma)), 1e-9);
}

// Where noise is overstated, matches are known better than they say. How far places are apart is
// measured in metres and does not shrink with it.
TEST(Evidence, OfAMatchGrowsWhereNoiseIsOverstated) {
  EvidenceModel overstated = model();
  overstated.variance_factor = 0.1;
  const double ratio =
      overstated.log_ratio(Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity(), match(kSpread));
  EXPECT_NEAR(ratio, std::log1p(kSpread * kSpread / (0.1 * kSigma * kSigma)), 1e-9);
}

TEST(Evidence, OfAMatchInAMapOfOnePlaceIsNone) {
  const Eigen::Vector3d b(0.5, -1.0, 2.0);
  EXPECT_NEAR(model().log_ratio(b, Eigen::Matrix3d::Identity(), match(0.0)), 0.0, 1e-9);
}

TEST(Evidence, OfAMatchIsNeverMoreThanThatOfAMotion) {
  const Between<SE2> motion(kFrom, kTo, SE2(1.0, 2.0, 0.3), noise());
  const Eigen::Matrix3d S = Eigen::Vector3d(4.0, 9.0, 2.0).asDiagonal();
  for (const double size : {0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0}) {
    for (const double spread : {0.1, 1.0, 20.0, 1e6}) {
      const Eigen::Vector3d b = size * Eigen::Vector3d(1.0, -0.5, 0.7);
      EXPECT_LE(model().log_ratio(b, S, match(spread)), model().log_ratio(b, S, motion));
    }
  }
}

}  // namespace
}  // namespace hybrid
