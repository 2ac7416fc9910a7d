// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/known_map.h"

#include <gtest/gtest.h>

#include "libhybrid/core/error.h"
#include "libhybrid/landmarks/landmark_association.h"

namespace hybrid {
namespace {

KnownMap known_with_ids(const std::vector<std::int64_t>& ids) {
  KnownMap known;
  for (const std::int64_t id : ids) {
    KnownLandmark landmark;
    landmark.id = id;
    landmark.covariance.setIdentity();
    landmark.existence = 3;
    known.landmarks.push_back(landmark);
  }
  return known;
}

TEST(KnownMap, LandmarksKeepTheirIds) {
  LandmarkAssociation association;
  association.adopt(known_with_ids({2, 7}), false);
  EXPECT_EQ(association.existence(), (std::map<std::int64_t, double>{{2, 3.0}, {7, 3.0}}));
}

TEST(KnownMap, LandmarksKeepTheirExtents) {
  KnownMap known = known_with_ids({2, 7});
  known.landmarks[1].size = {0.3, 2};
  LandmarkAssociation association;
  association.adopt(known, false);
  const Values values;
  const Assignment assignment;
  const LandmarkRegistry registry;
  const auto sizes = association.sizes({values, assignment, registry});
  EXPECT_EQ(sizes.at(2).extent, 0);
  EXPECT_EQ(sizes.at(7).extent, 0.3);
  EXPECT_EQ(sizes.at(7).things, 2);
}

TEST(KnownMap, IdsOfALogAreRefused) {
  for (const std::int64_t id : {std::int64_t{-1}, std::int64_t{1'000'000}, std::int64_t{1} << 40}) {
    LandmarkAssociation association;
    EXPECT_THROW(association.adopt(known_with_ids({id}), false), Error) << id;
  }
}

TEST(KnownMap, OtherClassesAreRefused) {
  ClassOptions options;
  options.names = {"tree", "car"};
  LandmarkAssociation association({}, ClassModel(options));
  KnownMap known = known_with_ids({0});
  known.class_names = {"tree", "boat"};
  known.landmarks[0].class_probabilities = {0.5, 0.5};
  EXPECT_THROW(association.adopt(known, false), Error);
}

}  // namespace
}  // namespace hybrid
