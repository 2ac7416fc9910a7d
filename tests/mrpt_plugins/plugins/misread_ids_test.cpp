// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/mrpt_plugins/plugins/beacon_world.h"

namespace hybrid {
namespace {

class MisreadIdsOf : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Plugins, MisreadIdsOf,
                         ::testing::Values("BearingRangeKnownIds", "ClassedBearingRangeKnownIds"));

// One id in 24 is that of another landmark: the map is about as good as without.
TEST_P(MisreadIdsOf, DoNotBendTheMap) {
  double worst = 0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    testing::BeaconWorld world(false, seed);
    Mapper mapper = testing::make_mapper(GetParam(), false);
    for (int i = 0; i < 90; ++i) {
      Keyframe keyframe = world.with_detections(i, true);
      if (i % 6 == 5) {
        Detection& misread = keyframe.detections[0].detections[i % 4];
        misread.id = (*misread.id + 2) % 4;
      }
      mapper.add(keyframe);
    }
    mapper.finish();
    const MapResult result = mapper.result();
    ASSERT_EQ(result.landmarks.size(), world.beacons.size());
    for (const LandmarkEstimate& landmark : result.landmarks) {
      const auto id = static_cast<std::size_t>(landmark.id);
      worst = std::max(worst, (landmark.position - world.beacons.at(id)).norm());
    }
  }
  EXPECT_LT(worst, 0.15);
}

}  // namespace
}  // namespace hybrid
