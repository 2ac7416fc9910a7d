// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "mrpt_plugins/health/health_lines.h"

#include <gtest/gtest.h>

#include <limits>

namespace hybrid {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

TEST(HealthLines, ABadVerdictHasALineAndAllDoubtfulOnesHaveOne) {
  const Health health = {
      {"copies", 0.0, 0, 0.1, HealthVerdict::kGood, "None.", ""},
      {"seen when in view", 0.4657, 0.5, 1, HealthVerdict::kDoubtful, "47 %.", "noise"},
      {"seen once", 0.5, 0, 0.1, HealthVerdict::kBad, "Half were seen once.", "odometry"},
      {"odometry", 7, -kNone, 5, HealthVerdict::kDoubtful, "Far.", "units"},
      {"closures", 0.25, 1, kNone, HealthVerdict::kDoubtful, "Narrow.", "margin"},
  };
  EXPECT_EQ(health_lines(health),
            (std::vector<std::string>{
                "warning: seen once: Half were seen once. Look at: odometry",
                "doubtful: seen when in view is 0.466 (good: 0.5 to 1), odometry is 7 (good: at "
                "most 5), closures is 0.25 (good: at least 1)"}));
}

TEST(HealthLines, NothingIsSaidOfWhatIsGood) {
  EXPECT_TRUE(health_lines({{"copies", 0, 0, 0.1, HealthVerdict::kGood, "None.", ""}}).empty());
  EXPECT_TRUE(health_lines({}).empty());
}

}  // namespace
}  // namespace hybrid
