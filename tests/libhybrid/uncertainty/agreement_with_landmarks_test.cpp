// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include "tests/libhybrid/uncertainty/circling_robot.h"

namespace hybrid {
namespace {

using namespace testing;

TEST(AgreementWithMap, OfDetectionsIsOneAmongItsLandmarksAndLessInAnotherPlace) {
  const auto landmarks = [](unsigned seed, bool is_3d, const Eigen::Vector3d& moved_by) {
    std::mt19937 random(seed);
    std::vector<KnownLandmark> map;
    for (const Eigen::Vector3d& thing : things_by(random, is_3d)) {
      KnownLandmark landmark;
      landmark.position = thing + moved_by;
      landmark.covariance = 1e-4 * Eigen::Matrix3d::Identity();
      map.push_back(landmark);
    }
    return map;
  };
  for (const bool is_3d : {false, true}) {
    const auto frames = detections(kLap, none, 1, is_3d);
    const Agreement right =
        agreement_with_map(frames, landmarks(1, is_3d, Eigen::Vector3d::Zero()));
    EXPECT_GT(right.looks, 50U);
    EXPECT_NEAR(right.ratio, 1, 0.1);
    EXPECT_LT(agreement_with_map(frames, landmarks(1, is_3d, {0.5, 0.3, 0})).ratio, 0.5);
    EXPECT_LT(agreement_with_map(frames, landmarks(2, is_3d, Eigen::Vector3d::Zero())).ratio, 0.3);
    EXPECT_EQ(agreement_with_map(frames, std::vector<KnownLandmark>()).looks, 0U);
  }
}

TEST(AgreementWithMap, OfDetectionsIsTheSameWhereverTheOriginOfTheMapIs) {
  std::mt19937 random(1);
  std::vector<KnownLandmark> map;
  for (const Eigen::Vector3d& thing : things_by(random, false)) {
    map.emplace_back().position = thing;
    map.back().covariance = 1e-4 * Eigen::Matrix3d::Identity();
  }
  std::vector<PlacedDetections> frames = detections(kLap, none);
  const Agreement here = agreement_with_map(frames, map);
  const Eigen::Vector3d away(-100, 30, 0);
  for (PlacedDetections& frame : frames) frame.T_map_sensor.pretranslate(away);
  for (KnownLandmark& landmark : map) landmark.position += away;
  const Agreement there = agreement_with_map(frames, map);
  EXPECT_EQ(there.looks, here.looks);
  EXPECT_NEAR(there.ratio, here.ratio, 1e-9);
}

}  // namespace
}  // namespace hybrid
