// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/remedies.h"

#include <gtest/gtest.h>

#include <limits>

namespace hybrid {
namespace {

constexpr const char* kFoundAgain = "landmarks seen at one time only";
constexpr const char* kCopies = "copies of landmarks";
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

TEST(Coarser, IsAskedOfLandmarksThatAreLostBeforeThoseThatAreCopied) {
  EXPECT_EQ(too_fine({check(kFoundAgain, 3), check("a", 9)}), nullptr);
  EXPECT_STREQ(too_fine({check(kCopies, 9), check(kFoundAgain, 9)}), kFoundAgain);
  EXPECT_STREQ(too_fine({check(kCopies, 9), check(kFoundAgain, 1)}), kCopies);
}

TEST(Coarser, IsGoodOnlyWhereLandmarksAreNotLostEither) {
  EXPECT_TRUE(is_good_by(kFoundAgain, {check(kFoundAgain, 1)}));
  EXPECT_FALSE(is_good_by(kFoundAgain, {check(kFoundAgain, 3)}));  // doubtful
  EXPECT_FALSE(is_good_by(kFoundAgain, {}));  // where nothing was asked, nothing is good
  EXPECT_TRUE(is_good_by(kCopies, {check(kFoundAgain, 3), check(kCopies, 1)}));
  EXPECT_FALSE(is_good_by(kCopies, {check(kFoundAgain, 9), check(kCopies, 1)}));
  EXPECT_FALSE(is_good_by(kCopies, {check(kCopies, 1)}));
}

/// A way of ten metres that turns by so much at each step, from a start of its own.
Trajectory way(double turn, double start = 0) {
  Trajectory out;
  mrpt::poses::CPose3D pose(start, -start, 0, start, 0, 0);
  for (int i = 0; i < 10; ++i) {
    out.push_back({static_cast<double>(i), pose});
    pose = pose + mrpt::poses::CPose3D(1, 0, 0, turn, 0, 0);
  }
  return out;
}

// Two ways to one map seldom lead to the same wrong one.
TEST(Agreement, IsOfTheTwoPathsThatAreMostAlikeWhereverTheyBegin) {
  EXPECT_EQ(first_of_agreeing({}), 0U);
  EXPECT_EQ(first_of_agreeing({way(0.1)}), 0U);
  EXPECT_EQ(first_of_agreeing({way(0.5), way(0.1), way(-0.3), way(0.12, 2)}), 1U);
  EXPECT_EQ(first_of_agreeing({way(0.1), way(0.12, 2), way(0.5)}), 0U);
  Trajectory other_times = way(0.5);
  for (auto& pose : other_times) pose.time += 0.5;
  EXPECT_EQ(first_of_agreeing({other_times, way(0.5), way(0.4), way(0)}), 1U);
}

// Landmarks that are found again are worth no other check that turns bad.
TEST(Coarser, MaySpoilNoOtherCheck) {
  const Health before{check(kFoundAgain, 9), check("path", 1)};
  EXPECT_FALSE(has_spoilt({check(kFoundAgain, 8), check("path", 1)}, before));
  EXPECT_TRUE(has_spoilt({check(kFoundAgain, 1), check("path", 9)}, before));
  EXPECT_TRUE(has_spoilt({check("scale", 9)}, before));
  EXPECT_FALSE(has_spoilt({check("path", 9)}, {check("path", 8)}));
  EXPECT_FALSE(has_spoilt({check("path", 4.2)}, {check("path", 3.5)}));  // doubtful before, and bad
  EXPECT_TRUE(has_spoilt({check("path", 4.2)}, {check("path", 1.9)}));
  EXPECT_FALSE(has_spoilt({check("path", 3.9)}, {check("path", 1)}));  // not bad
}

TEST(Coarser, GivesLandmarksExtentsInSigmasOfADetection) {
  Summary summary;
  summary.statistics["detection_sigma_m"] = 0.25;
  summary.provenance.configuration = {
      {"BearingRangeAssociation", {{"method", "hypotheses"}, {"extent", "0"}}}};
  ReplayRequest request;
  request.settings = {"a.b=c"};
  const std::vector<ReplayRequest> out = coarser(request, summary);
  ASSERT_EQ(out.size(), 3U);
  EXPECT_EQ(out[0].settings,
            (std::vector<std::string>{"a.b=c", "BearingRangeAssociation.method=jcbb",
                                      "BearingRangeAssociation.extent=0.25", kAllDetections}));
  EXPECT_EQ(out[2].settings[2], "BearingRangeAssociation.extent=1");
  summary.provenance.configuration[0].second[0].second = "jcbb";  // the user chose
  EXPECT_TRUE(coarser(request, summary).empty());
  summary.provenance.configuration[0].second = {{"method", "hypotheses"}, {"extent", "0.5"}};
  EXPECT_TRUE(coarser(request, summary).empty());
  summary.provenance.configuration[0].second[1].second = "0 1";  // of a class
  EXPECT_TRUE(coarser(request, summary).empty());
  summary.provenance.configuration[0].second[1].second = "0";
  summary.statistics.clear();
  EXPECT_TRUE(coarser(request, summary).empty());
}

HealthEntry agreement(HealthVerdict verdict) {
  HealthEntry entry = check("agreement over time", 1);
  entry.verdict = verdict;
  return entry;
}

TEST(AgreesBetter, AsksTheAgreementOverTimeFirst) {
  const HealthVerdict good = HealthVerdict::kGood, bad = HealthVerdict::kBad;
  EXPECT_TRUE(agrees_better({agreement(good), check("a", 9)}, {agreement(bad), check("a", 1)}));
  EXPECT_FALSE(agrees_better({agreement(bad), check("a", 1)}, {agreement(good), check("a", 9)}));
  EXPECT_TRUE(agrees_better({agreement(good), check("a", 1)}, {agreement(good), check("a", 9)}));
  EXPECT_FALSE(agrees_better({agreement(good), check("a", 9)}, {agreement(good), check("a", 9)}));
  const Health not_judged{agreement(HealthVerdict::kNotJudged), check("a", 1)};
  EXPECT_FALSE(agrees_better(not_judged, {agreement(good), check("a", 9)}));
  EXPECT_FALSE(agrees_better(not_judged, {agreement(HealthVerdict::kDoubtful), check("a", 9)}));
}

TEST(WithoutFixes, IsAskedWhereTheyMayBeWhatIsWrong) {
  Summary summary;
  summary.fixes.used = 100;
  summary.chosen_plugins = {"BearingRangeKnownIds", "Fixes"};
  const auto asked = [&](HealthVerdict over_time, double share_false) {
    summary.health = {agreement(over_time),
                      judged_entry("false fixes", share_false, {0.05, 0.2}, "", "")};
    return without_fixes({}, summary);
  };
  EXPECT_FALSE(asked(HealthVerdict::kGood, 0.1));
  EXPECT_FALSE(asked(HealthVerdict::kNotJudged, 0.1));
  EXPECT_TRUE(asked(HealthVerdict::kGood, 0.3));
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

TEST(Sparser, IsForDetectionsWhoseIntervalNobodyChose) {
  Summary summary;
  summary.statistics["detection_sigma_m"] = 0.1;
  summary.provenance.configuration = {{"keyframes", {{"min_time", "0"}}}};
  const std::vector<ReplayRequest> sparse = sparser({}, summary);
  ASSERT_EQ(sparse.size(), 3U);
  EXPECT_EQ(sparse[1].settings,
            (std::vector<std::string>{"sensor.noise=measured", "keyframes.min_time=1"}));
  summary.provenance.configuration = {{"keyframes", {{"min_time", "0.2"}}}};
  EXPECT_TRUE(sparser({}, summary).empty());
  summary.provenance.configuration = {{"keyframes", {{"min_time", "0"}}}};
  summary.statistics.clear();  // of scans
  EXPECT_TRUE(sparser({}, summary).empty());
}

TEST(FollowingLonger, IsForDirectionsWhoseMemoryNobodyChose) {
  Summary summary;
  summary.statistics = {{"detection_sigma_m", 0.1}, {"directions", 100}};
  const auto configure = [&](const char* memory) {
    summary.provenance.configuration = {
        {"BearingRangeAssociation", {{"memory", memory}, {"range_sigma", "0.3"}}},
        {"keyframes", {{"min_time", "0"}}}};
  };
  configure("2");
  const std::vector<ReplayRequest> longer = following_longer({}, summary);
  ASSERT_EQ(longer.size(), 2U);
  EXPECT_EQ(longer[0].settings, (std::vector<std::string>{"BearingRangeAssociation.memory=20"}));
  EXPECT_EQ(longer[1].settings.size(), 2U);
  EXPECT_TRUE(sparser({}, summary).empty());
  configure("5");
  EXPECT_TRUE(following_longer({}, summary).empty());
  configure("2");
  summary.statistics.erase("directions");
  EXPECT_TRUE(following_longer({}, summary).empty());
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
  HealthEntry unjudged = of_agreement(std::numeric_limits<double>::quiet_NaN());
  unjudged.verdict = HealthVerdict::kNotJudged;
  EXPECT_TRUE(agrees_better({of_agreement(0.3)}, {unjudged}));
  EXPECT_FALSE(agrees_better({unjudged}, {of_agreement(0.3)}));
}

}  // namespace
}  // namespace hybrid
