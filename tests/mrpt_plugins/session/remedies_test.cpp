// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/remedies.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace hybrid {
namespace {

constexpr const char* kAllDetections = "keyframes.tracklets=yes";
constexpr const char* kOdometry = "reader.odometry_sigma_factor";

HealthEntry check(const std::string& name, double value, const std::string& scale = "") {
  HealthEntry entry = judged_entry(name, value, {2, 4}, "", "");
  entry.scale = scale;
  return entry;
}

TEST(Remedies, CalibrateOdometryOnceBeforeItsNoiseIsScaled) {
  const Health health{check("noise of odometry", 5, kOdometry)};
  const IniFile::Settings stated{{"reader", {{"odometry_sigma_factor", "1.5"}}}};
  Remedies remedies;
  EXPECT_TRUE(remedies.add(health, stated));
  EXPECT_TRUE(remedies.calibrates);
  EXPECT_TRUE(remedies.factors.empty());
  EXPECT_EQ(remedies.apply({}).settings,
            (std::vector<std::string>{"sensor.noise=measured", "calibration.odometry=yes"}));
  remedies.calibrates = false;  // it was in vain
  EXPECT_TRUE(remedies.add(health, stated));
  EXPECT_FALSE(remedies.calibrates);
  EXPECT_EQ(remedies.factors.at(kOdometry), 7.5);
  EXPECT_TRUE(
      remedies.add(health, stated));  // the next map says it again, of what it was made with
  EXPECT_EQ(remedies.factors.at(kOdometry), 37.5);
  EXPECT_EQ(remedies.apply({}).settings,
            (std::vector<std::string>{"sensor.noise=measured", kOdometry + std::string("=37.5")}));
}

TEST(Remedies, AreOfBadChecksThatHaveAScale) {
  Remedies remedies;
  EXPECT_FALSE(remedies.add({check("a", 3, "sensor.x"), check("b", 9)}, {}));
  EXPECT_TRUE(remedies.add({check("a", 5, "sensor.x")}, {}));
  EXPECT_EQ(remedies.factors.at("sensor.x"), 5);
  EXPECT_FALSE(remedies.calibrates);
}

TEST(Remedies, WhatIsNoNumberInTheConfigurationCountsAsOne) {
  for (const char* text : {"", "none", "1e999"}) {
    Remedies remedies;
    EXPECT_TRUE(remedies.add({check("a", 5, "sensor.x")}, {{"sensor", {{"x", text}}}}));
    EXPECT_EQ(remedies.factors.at("sensor.x"), 5) << text;
  }
}

TEST(Draws, GiveLandmarksExtentsInSigmasOfADetection) {
  Summary summary;
  summary.statistics["detection_sigma_m"] = 0.25;
  summary.provenance.configuration = {
      {"BearingRangeAssociation", {{"method", "hypotheses"}, {"extent", "0"}}}};
  ReplayRequest request;
  request.settings = {"a.b=c"};
  const std::vector<ReplayRequest> out = draws(request, {request}, summary);
  ASSERT_EQ(out.size(), 6U);  // as it is, and measured
  EXPECT_EQ(out[0].settings,
            (std::vector<std::string>{"a.b=c", "BearingRangeAssociation.method=jcbb",
                                      "BearingRangeAssociation.extent=0.25", kAllDetections}));
  EXPECT_EQ(out[2].settings[2], "BearingRangeAssociation.extent=1");
  EXPECT_EQ(out[3].settings[1], kMeasuresNoise);
  summary.provenance.configuration[0].second[0].second = "jcbb";  // the user chose
  EXPECT_TRUE(draws(request, {request}, summary).empty());
  summary.provenance.configuration[0].second = {{"method", "hypotheses"}, {"extent", "0.5"}};
  EXPECT_TRUE(draws(request, {request}, summary).empty());
  summary.provenance.configuration[0].second[1].second = "0 1";  // of a class
  EXPECT_TRUE(draws(request, {request}, summary).empty());
  summary.provenance.configuration[0].second[1].second = "0";
  summary.statistics.clear();
  EXPECT_TRUE(draws(request, {request}, summary).empty());
}

HealthEntry agreement(HealthVerdict verdict, double value = 1) {
  HealthEntry entry = check("agreement over time", value);
  entry.verdict = verdict;
  if (verdict == HealthVerdict::kNotJudged) {
    entry.value = std::numeric_limits<double>::quiet_NaN();
  }
  return entry;
}

TEST(AgreesBetter, AsksTheAgreementOverTimeFirst) {
  const HealthVerdict good = HealthVerdict::kGood, bad = HealthVerdict::kBad;
  const HealthEntry torn = agreement(bad, 0.4);
  EXPECT_TRUE(agrees_better({agreement(good), check("a", 9)}, {torn, check("a", 1)}));
  EXPECT_FALSE(agrees_better({torn, check("a", 1)}, {agreement(good), check("a", 9)}));
  EXPECT_TRUE(agrees_better({agreement(good), check("a", 1)}, {agreement(good), check("a", 9)}));
  EXPECT_FALSE(agrees_better({agreement(good), check("a", 9)}, {agreement(good), check("a", 9)}));
  const Health not_judged{agreement(HealthVerdict::kNotJudged), check("a", 1)};
  EXPECT_FALSE(agrees_better(not_judged, {agreement(good), check("a", 9)}));
  EXPECT_FALSE(agrees_better(not_judged, {agreement(HealthVerdict::kDoubtful), check("a", 9)}));
}

TEST(AgreesBetter, DoesNotTakeACalibrationThatIsNotCredible) {
  HealthEntry scale = check("scale of rotation of odometry", 9);
  scale.is_optional = true;
  const Health calibrated{agreement(HealthVerdict::kBad, 0.6), scale};
  EXPECT_FALSE(agrees_better(calibrated, {agreement(HealthVerdict::kBad, 0.2), check("a", 9)}));
  scale.value = 1;
  scale.verdict = HealthVerdict::kGood;
  EXPECT_TRUE(agrees_better({agreement(HealthVerdict::kBad, 0.6), scale},
                            {agreement(HealthVerdict::kBad, 0.2), check("a", 9)}));
}

TEST(AgreesBetter, TakesAMapWithoutFixesWhereTheseAreBad) {
  HealthEntry fixes = check("biased fixes", 9);
  fixes.is_optional = true;
  const Health with{agreement(HealthVerdict::kNotJudged), check("a", 9), fixes};
  const Health without{agreement(HealthVerdict::kNotJudged), check("a", 1)};
  EXPECT_TRUE(agrees_better(without, with));
  EXPECT_FALSE(agrees_better(with, without));
}

TEST(WithStatedNoise, IsAskedWhereFixesAreBad) {
  Summary summary;
  summary.fixes.used = 100;
  summary.fixes.asks_modes = true;
  ReplayRequest request;
  request.settings = {"sensor.noise=measured", "calibration.odometry=yes"};
  EXPECT_FALSE(with_stated_noise(request, summary));
  summary.fixes.wrong = 40;
  EXPECT_EQ(with_stated_noise(request, summary)->settings,
            (std::vector<std::string>{"calibration.odometry=yes", "sensor.noise=stated"}));
}

TEST(WithoutFixes, IsAskedWhereTheyMayBeWhatIsWrong) {
  Summary summary;
  summary.fixes.used = 100;
  summary.fixes.asks_modes = true;
  summary.chosen_plugins = {"BearingRangeKnownIds", "Fixes"};
  const auto asked = [&](HealthVerdict over_time, double share_false) {
    summary.health = {agreement(over_time)};
    summary.fixes.wrong = static_cast<std::size_t>(std::lround(share_false * 100));
    return without_fixes({}, summary);
  };
  EXPECT_FALSE(asked(HealthVerdict::kGood, 0.1));
  EXPECT_FALSE(asked(HealthVerdict::kNotJudged, 0.1));
  EXPECT_TRUE(asked(HealthVerdict::kGood, 0.3));
  summary.fixes.bias_share = 0.6;
  EXPECT_TRUE(asked(HealthVerdict::kNotJudged, 0));
  summary.fixes.bias_share = 0.3;
  EXPECT_FALSE(asked(HealthVerdict::kNotJudged, 0));
  const auto without = asked(HealthVerdict::kDoubtful, 0);
  ASSERT_TRUE(without);
  EXPECT_EQ(without->settings, (std::vector<std::string>{"plugins.classes=BearingRangeKnownIds"}));
  summary.chosen_plugins.clear();
  summary.provenance.configuration = {{"plugins", {{"classes", "Fixes LaserScans Own"}}}};
  EXPECT_EQ(asked(HealthVerdict::kBad, 0)->settings.front(), "plugins.classes=LaserScans Own");
  summary.provenance.configuration = {{"plugins", {{"classes", "Fixes"}}}};
  EXPECT_FALSE(asked(HealthVerdict::kBad, 0));
  summary.fixes.used = 0;
  summary.chosen_plugins = {"BearingRangeKnownIds", "Fixes"};
  EXPECT_FALSE(asked(HealthVerdict::kBad, 0));
}

TEST(Draws, BeginWithWhatTheTakenMapHadAndEndWithFewerKeyframes) {
  Summary summary;
  summary.statistics["detection_sigma_m"] = 0.25;
  summary.provenance.configuration = {
      {"BearingRangeAssociation", {{"method", "hypotheses"}, {"extent", "0"}}},
      {"keyframes", {{"min_time", "0"}}}};
  ReplayRequest taken;
  taken.settings = {"reader.odometry_sigma_factor=3"};
  const std::vector<ReplayRequest> out = draws({}, {taken}, summary);
  ASSERT_EQ(out.size(), 9U);
  EXPECT_EQ(out[0].settings.front(), "reader.odometry_sigma_factor=3");
  EXPECT_EQ(out[2].settings.front(), "reader.odometry_sigma_factor=3");
  EXPECT_EQ(out[3].settings.front(), "sensor.noise=measured");
  EXPECT_EQ(out[5].settings[2], "BearingRangeAssociation.extent=1");
  EXPECT_EQ(out[6].settings,
            (std::vector<std::string>{"sensor.noise=measured", "keyframes.min_time=0.5"}));
}

TEST(Draws, CalibrateTheOdometryFirstWhereNobodyHas) {
  Summary summary;
  summary.statistics["detection_sigma_m"] = 0.25;
  summary.provenance.configuration = {{"calibration", {{"odometry", "false"}}}};
  ReplayRequest taken;
  taken.settings = {"a.b=c"};
  const std::vector<ReplayRequest> out = draws({}, {taken}, summary);
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[0].settings, (std::vector<std::string>{"a.b=c", "calibration.odometry=yes"}));
  EXPECT_EQ(out[1].settings,
            (std::vector<std::string>{"sensor.noise=measured", "calibration.odometry=yes"}));
  summary.provenance.configuration = {{"calibration", {{"odometry", "true"}}}};
  EXPECT_TRUE(draws({}, {ReplayRequest()}, summary).empty());
  summary.statistics.clear();  // of scans
  summary.provenance.configuration = {{"calibration", {{"odometry", "false"}}}};
  EXPECT_TRUE(draws({}, {ReplayRequest()}, summary).empty());
}

TEST(Draws, AreSparserWhereTheLogIsOfDetectionsWhoseIntervalNobodyChose) {
  Summary summary;
  summary.statistics["detection_sigma_m"] = 0.1;
  summary.provenance.configuration = {{"keyframes", {{"min_time", "0"}}}};
  const std::vector<ReplayRequest> sparse = draws({}, {ReplayRequest()}, summary);
  ASSERT_EQ(sparse.size(), 3U);
  EXPECT_EQ(sparse[1].settings,
            (std::vector<std::string>{"sensor.noise=measured", "keyframes.min_time=1"}));
  summary.provenance.configuration = {{"keyframes", {{"min_time", "0.2"}}}};
  EXPECT_TRUE(draws({}, {ReplayRequest()}, summary).empty());
  summary.provenance.configuration = {{"keyframes", {{"min_time", "0"}}}};
  summary.statistics.clear();  // of scans
  EXPECT_TRUE(draws({}, {ReplayRequest()}, summary).empty());
}

TEST(Draws, FollowLongerWhereTheLogIsOfDirectionsWhoseMemoryNobodyChose) {
  Summary summary;
  summary.statistics = {{"detection_sigma_m", 0.1}, {"directions", 100}};
  const auto configure = [&](const char* memory) {
    summary.provenance.configuration = {
        {"BearingRangeAssociation", {{"memory", memory}, {"range_sigma", "0.3"}}},
        {"keyframes", {{"min_time", "0"}}}};
  };
  configure("2");
  const std::vector<ReplayRequest> longer = draws({}, {ReplayRequest()}, summary);
  ASSERT_EQ(longer.size(), 2U);
  EXPECT_EQ(longer[0].settings, (std::vector<std::string>{"BearingRangeAssociation.memory=20"}));
  EXPECT_EQ(longer[1].settings.size(), 2U);
  configure("5");
  EXPECT_TRUE(draws({}, {ReplayRequest()}, summary).empty());
  configure("2");
  summary.statistics.erase("directions");
  EXPECT_EQ(draws({}, {ReplayRequest()}, summary).size(), 3U);  // sparser ones
}

HealthEntry of_agreement(double value) {
  HealthEntry entry;
  entry.name = "agreement over time";
  entry.value = value;
  entry.verdict = value < 0.9 ? HealthVerdict::kBad : HealthVerdict::kGood;
  return entry;
}

TEST(AgreesBetter, OfBadMapsTheOneWithTheLargerShare) {
  EXPECT_TRUE(agrees_better({of_agreement(0.6)}, {of_agreement(0.3)}));
  EXPECT_FALSE(agrees_better({of_agreement(0.3)}, {of_agreement(0.6)}));
  EXPECT_FALSE(agrees_better({of_agreement(0.61)}, {of_agreement(0.6)}));  // within its sigma
  EXPECT_TRUE(agrees_better({of_agreement(1)}, {of_agreement(0.8)}));
  // A share a little above the limit does not outweigh other checks, but tells where they do not.
  HealthEntry doubtful = of_agreement(0.89);
  doubtful.verdict = HealthVerdict::kDoubtful;
  EXPECT_FALSE(agrees_better({of_agreement(0.92), check("a", 9)}, {doubtful, check("a", 1)}));
  EXPECT_TRUE(agrees_better({of_agreement(0.92), check("a", 9)}, {doubtful, check("a", 9)}));
  EXPECT_FALSE(agrees_better({doubtful, check("a", 9)}, {of_agreement(0.92), check("a", 9)}));
  HealthEntry less = doubtful;
  less.value = 0.87;
  EXPECT_FALSE(agrees_better({less, check("a", 1)}, {doubtful, check("a", 3)}));
  EXPECT_TRUE(agrees_better({doubtful, check("a", 1)}, {less, check("a", 3)}));
  HealthEntry unjudged = of_agreement(std::numeric_limits<double>::quiet_NaN());
  unjudged.verdict = HealthVerdict::kNotJudged;
  EXPECT_TRUE(agrees_better({of_agreement(0.3)}, {unjudged}));
  const Health right{unjudged, check("a", 1)}, wrong{unjudged, check("a", 9)};
  const Health bad{of_agreement(0.3), check("a", 1)};
  EXPECT_TRUE(agrees_better(right, bad));
  EXPECT_FALSE(agrees_better(bad, right));
  EXPECT_FALSE(agrees_better(wrong, bad));
  EXPECT_TRUE(agrees_better(bad, wrong));
  EXPECT_FALSE(agrees_better(right, {of_agreement(0.3), check("a", 1), check("b", 1)}));
  EXPECT_FALSE(agrees_better({unjudged}, {of_agreement(0.3)}));
}

}  // namespace
}  // namespace hybrid
