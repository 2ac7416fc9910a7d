// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cmath>

#include "mrpt_plugins/health/fix_figures.h"
#include "mrpt_plugins/health/run_health.h"

namespace hybrid {
namespace {

/// A fix each second, its mode by the letters g, b, f; "-": it is not in the map.
MapResult with_fixes(const std::string& modes) {
  MapResult result;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    FixEstimate fix;
    fix.time = 100 + static_cast<double>(i);
    fix.keyframe = i;
    if (modes[i] == 'g') fix.mode = FixMode::kGood;
    if (modes[i] == 'b') fix.mode = FixMode::kBiased;
    if (modes[i] == 'f') fix.mode = FixMode::kFalse;
    if (fix.mode) fix.probabilities = {0.5, 0.3, 0.2};
    result.fixes.push_back(fix);
  }
  return result;
}

Health health_of(const MapResult& result) {
  HybridGraph graph;
  Estimate estimate;
  const std::map<std::string, std::size_t> none;
  return run_health({graph, estimate, result, none});
}

/// So many fixes of modes, one mode after the other.
std::string modes(int good, int biased, int wrong) {
  const auto many = [](int n, char c) { return std::string(static_cast<std::size_t>(n), c); };
  return many(good, 'g') + many(biased, 'b') + many(wrong, 'f');
}

TEST(FixFigures, CountRunsThatFalseFixesDoNotEnd) {
  const FixFigures figures = fix_figures(with_fixes("gggbbfbbg-gbg"));
  EXPECT_EQ(figures.count, 13U);
  EXPECT_EQ(figures.used, 12U);
  EXPECT_EQ(figures.good, 6U);
  EXPECT_EQ(figures.biased, 5U);
  EXPECT_EQ(figures.wrong, 1U);
  EXPECT_TRUE(figures.asks_modes);
  EXPECT_EQ(figures.bias_runs, 2U);
  EXPECT_DOUBLE_EQ(figures.longest_bias, 5);  // from 2.5 to 7.5
  EXPECT_DOUBLE_EQ(figures.bias_share, (5.0 + 1.0) / 12);
}

TEST(FixFigures, AMinuteWithoutFixesEndsARunAndDoesNotCount) {
  MapResult result = with_fixes("gbbg");
  result.fixes[2].time += 100;
  result.fixes[3].time += 100;
  const FixFigures figures = fix_figures(result);
  EXPECT_EQ(figures.bias_runs, 2U);
  EXPECT_DOUBLE_EQ(figures.longest_bias, 0.5);
  EXPECT_DOUBLE_EQ(figures.bias_share, 0.5);
}

TEST(FixFigures, RobotsHaveRunsOfTheirOwn) {
  MapResult result = with_fixes("gbgbgb");
  result.robots = {{"a", {0, 2, 4}}, {"b", {1, 3, 5}}};
  const FixFigures figures = fix_figures(result);
  EXPECT_EQ(figures.bias_runs, 1U);
  EXPECT_DOUBLE_EQ(figures.longest_bias, 4);
  EXPECT_DOUBLE_EQ(figures.bias_share, 0.5);
}

TEST(FixHealth, IsByTheSharesOfFalseAndBiasedOnes) {
  const auto verdicts = [](const std::string& letters) {
    const Health health = health_of(with_fixes(letters));
    EXPECT_EQ(health.size(), 2U);
    EXPECT_EQ(health[0].name, "false fixes");
    EXPECT_EQ(health[1].name, "biased fixes");
    for (const HealthEntry& entry : health) {
      const bool has_knob = entry.verdict > HealthVerdict::kGood;
      EXPECT_EQ(!entry.knob.empty(), has_knob) << entry.name;
    }
    return std::pair(health[0].verdict, health[1].verdict);
  };
  const HealthVerdict good = HealthVerdict::kGood, doubtful = HealthVerdict::kDoubtful,
                      bad = HealthVerdict::kBad;
  EXPECT_EQ(verdicts(modes(100, 0, 0)), std::pair(good, good));
  EXPECT_EQ(verdicts(modes(78, 20, 2)), std::pair(good, good));
  EXPECT_EQ(verdicts(modes(60, 30, 10)), std::pair(doubtful, doubtful));
  EXPECT_EQ(verdicts(modes(20, 55, 25)), std::pair(bad, bad));
}

TEST(FixHealth, SaysHowLongItWasBiased) {
  const Health health = health_of(with_fixes(modes(70, 30, 0)));
  EXPECT_EQ(health[1].sentence,
            "Fixes were biased for 30 % of the time, in 1 run, the longest 30 s.");
}

TEST(FixHealth, IsNotJudgedWhereThereAreTooFewOrNoModes) {
  EXPECT_TRUE(health_of({}).empty());
  MapResult plain = with_fixes(modes(100, 0, 0));
  for (FixEstimate& fix : plain.fixes) fix.probabilities = {};
  for (const MapResult& result : {with_fixes(modes(10, 0, 0) + std::string(90, '-')), plain}) {
    for (const HealthEntry& entry : health_of(result)) {
      EXPECT_EQ(entry.verdict, HealthVerdict::kNotJudged);
      EXPECT_TRUE(std::isnan(entry.value));
      EXPECT_FALSE(entry.sentence.empty());
    }
  }
}

}  // namespace
}  // namespace hybrid
