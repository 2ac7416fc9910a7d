// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/health/closures.h"

#include <gtest/gtest.h>

#include <limits>

namespace hybrid {
namespace {

ClosureDecision closure(bool accepted, double margin) {
  ClosureDecision decision;
  decision.accept(accepted);
  decision.margin = margin;
  return decision;
}

TEST(ClosureHealth, CountsWhatIsRejectedAndTheLeastMargin) {
  std::vector<ClosureDecision> closures(20, closure(true, 40));
  EXPECT_EQ(worst(closure_health(closures)), HealthVerdict::kGood);
  closures[3].margin = 1;
  EXPECT_EQ(worst(closure_health(closures)), HealthVerdict::kDoubtful);
  EXPECT_EQ(closure_health(closures).back().value, 1);
  closures[3].checkable = false;  // nothing else tells, so the margin says nothing
  EXPECT_EQ(worst(closure_health(closures)), HealthVerdict::kGood);
  for (ClosureDecision& decision : closures) decision.accept(false);
  EXPECT_EQ(worst(closure_health(closures)), HealthVerdict::kBad);
  EXPECT_EQ(closure_health(closures).front().value, 1);
}

TEST(ClosureHealth, LeavesOutClosuresThatWereNotInQuestion) {
  std::vector<ClosureDecision> closures(20, closure(true, 40));
  closures.resize(30, ClosureDecision::trusted());
  EXPECT_EQ(worst(closure_health(closures)), HealthVerdict::kGood);  // their margin is 0
  EXPECT_TRUE(closure_health(std::vector<ClosureDecision>(9, ClosureDecision::trusted())).empty());
}

TEST(ClosureHealth, SaysNothingOfAFew) {
  EXPECT_TRUE(closure_health({closure(false, 40), closure(false, 40)}).empty());
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(closure_health(std::vector<ClosureDecision>(9, closure(true, unknown))).size(), 1U);
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
