// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/landmarks/known_map.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"
#include "tests/mrpt_plugins/plugins/beacon_world.h"

namespace hybrid {
namespace {

class NumberedMapOf : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Plugins, NumberedMapOf,
                         ::testing::Values("BearingRangeKnownIds", "ClassedBearingRangeKnownIds",
                                           "BearingOnlyKnownIds", "BeaconRanges"));

TEST_P(NumberedMapOf, IsNotMixedWithIdsOfALog) {
  IniFile ini;
  const auto plugin = make_plugin(GetParam(), ini);
  KnownMap known;
  EXPECT_NO_THROW(plugin->adopt(known, false));
  known.identified = false;
  try {
    plugin->adopt(known, false);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("numbered by the program that made it"), std::string::npos)
        << e.what();
  }
}

/// Of the beacons of the world, numbered the other way round.
KnownMap reversed(const testing::BeaconWorld& world) {
  KnownMap known;
  known.identified = false;
  known.class_names = {"lamp", "door"};
  const std::size_t n = world.beacons.size();
  for (std::size_t k = 0; k < n; ++k) {
    KnownLandmark landmark;
    landmark.id = static_cast<std::int64_t>(k);
    landmark.position = world.beacons[n - 1 - k];
    landmark.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    landmark.class_probabilities = {0.5, 0.5};
    landmark.existence = 3;
    landmark.sightings = 10;
    known.landmarks.push_back(landmark);
    known.prior.push_back(std::make_shared<Prior<Eigen::Vector2d>>(
        position_key(landmark.id), landmark.position.head<2>(), Noise::isotropic(2, 0.01)));
  }
  return known;
}

TEST(NumberedMap, IdsOfALogAreLearnedByTheirPlaces) {
  testing::BeaconWorld world(false);
  Mapper mapper = testing::make_mapper("BearingRangeAssociation", false);
  mapper.adopt(reversed(world));
  for (int i = 0; i < 20; ++i) mapper.add(world.with_detections(i, true));
  mapper.finish();
  const MapResult result = mapper.result();
  ASSERT_EQ(result.landmarks.size(), world.beacons.size());
  for (const LandmarkEstimate& landmark : result.landmarks) {
    const auto k = world.beacons.size() - 1 - static_cast<std::size_t>(landmark.id);
    EXPECT_LT((landmark.position - world.beacons.at(k)).norm(), 0.1) << landmark.id;
  }
}

}  // namespace
}  // namespace hybrid
