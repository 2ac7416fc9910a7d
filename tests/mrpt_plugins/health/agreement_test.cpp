// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "mrpt_plugins/health/agreement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mrpt_plugins/health/run_health.h"

namespace hybrid {
namespace {

Agreement agreement(double ratio, double sigma) {
  Agreement out;
  out.soon = 0.8;
  out.late = 0.8 * ratio;
  out.soon = 0.8;
  out.late = 0.8 * ratio;
  out.ratio = ratio;
  out.sigma = sigma;
  out.looks = 1000;
  out.stretches = {{100, 1.0, 500}, {120, 2 * ratio - 1, 500}, {140, 0.1, 1}};
  return out;
}

HealthVerdict verdict(double ratio, double sigma) {
  return worst(agreement_health(agreement(ratio, sigma), {}));
}

TEST(AgreementHealth, IsBadOrDoubtfulWhereTheRatioAndItsSigmaAreBelowThatOfARightPath) {
  EXPECT_EQ(verdict(1.0, 0.01), HealthVerdict::kGood);
  EXPECT_EQ(verdict(0.95, 0.03), HealthVerdict::kGood);
  EXPECT_EQ(verdict(0.95, 0.01), HealthVerdict::kDoubtful);
  EXPECT_EQ(verdict(0.8, 0.12), HealthVerdict::kDoubtful);
  EXPECT_EQ(verdict(0.8, 0.05), HealthVerdict::kBad);
  EXPECT_EQ(verdict(0.3, 0.5), HealthVerdict::kBad);
}

// A map of nearly nothing, metres off.
TEST(AgreementHealth, IsNotJudgedWhereItTellsNothing) {
  for (const double ratio : {0.93, 1.2}) {
    const HealthEntry entry = agreement_health(agreement(ratio, 0.3), {}).front();
    EXPECT_EQ(entry.verdict, HealthVerdict::kNotJudged);
  }
  const HealthEntry entry = agreement_health(agreement(1.2, 0.55), {}).front();
  EXPECT_TRUE(std::isnan(entry.value));
  EXPECT_NE(entry.sentence.find("too unsure"), std::string::npos);
  EXPECT_EQ(agreement_of({entry}), HealthVerdict::kBad);
}

TEST(AgreementHealth, SaysWhatIsComparedWhereNothingIsFoundSoon) {
  Agreement bent = agreement(0.4, 0.1);
  bent.soon = 0.02;
  bent.late = 0.04;
  const HealthEntry entry = agreement_health(bent, {}).front();
  EXPECT_EQ(entry.verdict, HealthVerdict::kBad);
  EXPECT_NE(entry.sentence.find("0.40 +- 0.10 of the 10 % that"), std::string::npos)
      << entry.sentence;
}

TEST(AgreementHealth, HasAnEntryForDetectionsAndOneForScans) {
  EXPECT_EQ(agreement_health(agreement(1, 0.1), {}).size(), 1U);
  const Health both = agreement_health(agreement(1, 0.1), agreement(0.5, 0.1));
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[0].name, "agreement over time");
  EXPECT_EQ(both[1].name, "agreement over time");
  EXPECT_EQ(both[1].verdict, HealthVerdict::kBad);
  EXPECT_EQ(both[1].value, 0.5);
}

// A path that is wrong for a minute brings few of all looks astray.
TEST(AgreementHealth, IsDoubtfulWhereAStretchAgreesWithNothing) {
  for (const auto& [ratio, places, verdict] :
       {std::tuple{0.1, 9U, HealthVerdict::kDoubtful}, std::tuple{0.7, 9U, HealthVerdict::kGood},
        std::tuple{0.1, 2U, HealthVerdict::kGood}}) {
    Agreement found = agreement(1, 0.02);
    found.stretches[1] = {120, ratio, 40, places};
    const HealthEntry entry = agreement_health(found, {}).front();
    EXPECT_EQ(entry.verdict, verdict) << ratio << " " << places;
    EXPECT_EQ(entry.knob.find("20 s after") != std::string::npos,
              verdict == HealthVerdict::kDoubtful)
        << entry.knob;
  }
}

TEST(AgreementHealth, TellsWhenTheMostDoesNotAgree) {
  const HealthEntry entry = agreement_health(agreement(0.5, 0.1), {}).front();
  EXPECT_NE(entry.knob.find("20 s after"), std::string::npos) << entry.knob;
  ASSERT_EQ(entry.over_time.size(), 3U);
  EXPECT_EQ(entry.over_time[1].time, 120);
  EXPECT_EQ(entry.over_time[1].value, 0.0);
  EXPECT_EQ(entry.over_time[1].weight, 500);
}

TEST(AgreementHealth, IsNotJudgedWhereNothingIsSeenAgain) {
  Agreement alone = agreement(0.5, std::numeric_limits<double>::infinity());
  for (const Health& health : {agreement_health({}, {}), agreement_health(alone, {})}) {
    ASSERT_EQ(health.size(), 1U);
    EXPECT_EQ(health[0].verdict, HealthVerdict::kNotJudged);
    EXPECT_TRUE(std::isnan(health[0].value));
    EXPECT_EQ(worst(health), HealthVerdict::kGood);
    EXPECT_TRUE(health[0].over_time.empty());
  }
}

TEST(MapAgreementHealth, HasTheLimitsOfAgreementOverTime) {
  for (const double ratio : {0.98, 0.95, 0.8}) {
    const Agreement found = agreement(ratio, 0.01);
    const HealthEntry entry = map_agreement_health(found).value();
    EXPECT_EQ(entry.name, "agreement with the map");
    EXPECT_EQ(entry.verdict, agreement_health({}, found).front().verdict);
    EXPECT_EQ(entry.over_time.size(), 3U);
  }
  EXPECT_FALSE(map_agreement_health({}));
  EXPECT_FALSE(map_agreement_health(agreement(0.7, std::numeric_limits<double>::infinity())));
}

TEST(AgreementHealth, WhereItIsGoodAScaleThatNoWheelHasIsOnlyDoubtful) {
  const HybridGraph graph;
  const Estimate estimate;
  const MapResult result;
  const std::map<std::string, std::size_t> none;
  for (const auto& [turn, verdict] :
       {std::pair{0.97, HealthVerdict::kGood}, std::pair{0.93, HealthVerdict::kDoubtful},
        std::pair{1.96, HealthVerdict::kBad}, std::pair{0.66, HealthVerdict::kBad}}) {
    const std::map<std::string, double> figures = {
        {"scans", 1000}, {"odometry_times_translation", 1.01}, {"odometry_times_rotation", turn}};
    for (const bool agrees : {false, true}) {
      const Health health = run_health({graph, estimate, result, none, 0, figures, agrees});
      const auto entry = std::find_if(health.begin(), health.end(), [](const HealthEntry& e) {
        return e.name == "scale of the odometry by scans";
      });
      ASSERT_NE(entry, health.end());
      EXPECT_EQ(entry->verdict, agrees ? std::min(verdict, HealthVerdict::kDoubtful) : verdict);
    }
  }
}

TEST(AgreementHealth, AScaleThatIsNotPositiveIsNotMeasured) {
  const HybridGraph graph;
  const Estimate estimate;
  const MapResult result;
  const std::map<std::string, std::size_t> none;
  for (const auto& [length, turn] : {std::pair{1.0, -0.3}, std::pair{-1.0, 1.0}}) {
    const std::map<std::string, double> figures = {
        {"scans", 1000}, {"odometry_times_translation", length}, {"odometry_times_rotation", turn}};
    for (const HealthEntry& entry : run_health({graph, estimate, result, none, 0, figures, true})) {
      EXPECT_NE(entry.name, "scale of the odometry by scans") << entry.sentence;
    }
  }
}

}  // namespace
}  // namespace hybrid
