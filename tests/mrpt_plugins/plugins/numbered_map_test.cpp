// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/landmarks/known_map.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace hybrid {
namespace {

class NumberedMap : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Plugins, NumberedMap,
                         ::testing::Values("BearingRangeKnownIds", "ClassedBearingRangeKnownIds",
                                           "BearingOnlyKnownIds"));

TEST_P(NumberedMap, IsNotMixedWithIdsOfALog) {
  IniFile ini;
  const auto plugin = make_plugin(GetParam(), ini);
  KnownMap known;
  EXPECT_NO_THROW(plugin->adopt(known, false));
  known.identified = false;
  try {
    plugin->adopt(known, false);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("sensor.ids=none"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace hybrid
