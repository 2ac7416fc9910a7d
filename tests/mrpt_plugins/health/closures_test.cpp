// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/health/closures.h"

#include <gtest/gtest.h>

#include <limits>

namespace hybrid {
namespace {

TEST(ClosureHealth, CountsWhatIsRejectedAndTheLeastMargin) {
  std::vector<JudgedClosure> closures(20, {true, true, 40});
  EXPECT_EQ(worst(closure_health(closures)), HealthVerdict::kGood);
  closures[3].margin = 1;
  EXPECT_EQ(worst(closure_health(closures)), HealthVerdict::kDoubtful);
  EXPECT_EQ(closure_health(closures).back().value, 1);
  closures[3].checkable = false;  // nothing else tells, so the margin says nothing
  EXPECT_EQ(worst(closure_health(closures)), HealthVerdict::kGood);
  for (JudgedClosure& closure : closures) closure.accepted = false;
  EXPECT_EQ(worst(closure_health(closures)), HealthVerdict::kBad);
  EXPECT_EQ(closure_health(closures).front().value, 1);
}

TEST(ClosureHealth, SaysNothingOfAFew) {
  EXPECT_TRUE(closure_health({{false, true, 40}, {false, true, 40}}).empty());
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(closure_health(std::vector<JudgedClosure>(9, {true, true, unknown})).size(), 1U);
}

TEST(Health, TheWorstVerdictIsThatOfAll) {
  HealthEntry good, bad;
  bad.verdict = HealthVerdict::kBad;
  EXPECT_EQ(worst({}), HealthVerdict::kGood);
  EXPECT_EQ(worst({good, bad, good}), HealthVerdict::kBad);
  EXPECT_EQ(judge(0.3, {0.1, 0.5}), HealthVerdict::kDoubtful);
  EXPECT_STREQ(to_string(HealthVerdict::kBad), "bad");
}

}  // namespace
}  // namespace hybrid
