// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/conditions.h"

#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

HealthEntry entry(const std::string& name, double value) {
  return judged_entry(name, value, {2, 4}, "", "");
}

TEST(IsBetter, CountsTheWorstChecks) {
  const Health two_bad{entry("a", 8), entry("b", 8)}, one_bad{entry("a", 1), entry("b", 8)};
  EXPECT_TRUE(is_better(one_bad, two_bad));
  EXPECT_FALSE(is_better(two_bad, one_bad));
  EXPECT_FALSE(is_better(one_bad, one_bad));
  const Health doubtful{entry("a", 3)}, good{entry("a", 1)};
  EXPECT_TRUE(is_better(good, doubtful));
  EXPECT_FALSE(is_better(good, good));
}

TEST(IsBetter, IsNotWhereOneCheckIsMuchWorse) {
  const Health before{entry("a", 8), entry("b", 8)};
  EXPECT_TRUE(is_better({entry("a", 1), entry("b", 8.5)}, before));  // the same but for chance
  EXPECT_FALSE(is_better({entry("a", 1), entry("b", 9.5)}, before));
  // What was doubtful before and is bad now is worse, whatever else is good.
  EXPECT_FALSE(is_better({entry("a", 1), entry("b", 5)}, {entry("a", 3), entry("b", 3)}));
}

TEST(IsBetter, IsNotWhereLessIsAsked) {
  EXPECT_FALSE(is_better({}, {entry("a", 8)}));
  EXPECT_FALSE(is_better({entry("b", 1)}, {entry("a", 8), entry("b", 1)}));
  HealthEntry scale = entry("scale of the odometry", 1);
  scale.is_optional = true;  // which the other map was not asked for
  EXPECT_TRUE(is_better({entry("a", 1)}, {entry("a", 8), scale}));
  EXPECT_TRUE(is_better({entry("b", 1), entry("c", 1)}, {entry("a", 8), entry("b", 1)}));
  HealthEntry not_judged;
  not_judged.verdict = HealthVerdict::kNotJudged;
  EXPECT_FALSE(is_better({not_judged, entry("b", 1)}, {entry("a", 8), entry("b", 1)}));
}

TEST(Conditions, WantWhatIsBetterAndNotStopped) {
  const Health other{entry("a", 8)}, good{entry("a", 1)};
  EXPECT_TRUE(Conditions{}.want(other, 2));  // the first map is written, stopped or not
  Conditions conditions;
  conditions.other = &other;
  EXPECT_TRUE(conditions.want(good, 0));
  EXPECT_FALSE(conditions.want(good, 2));
  EXPECT_FALSE(conditions.want(other, 0));
  conditions.better = [](const Health&, const Health&) { return false; };
  EXPECT_FALSE(conditions.want(good, 0));
}

TEST(Conditions, AllowWhatIsCorrectedAsFarAsAsked) {
  ReplaySettings settings;
  settings.robots.resize(2);
  EXPECT_TRUE(Conditions{}.allow(settings));
  Conditions corrected;
  corrected.corrected = true;
  EXPECT_FALSE(corrected.allow(settings));
  LogCorrection& correction = settings.robots[1].source.correction;
  correction.translation = 2;  // noise of odometry
  EXPECT_TRUE(corrected.allow(settings));
  corrected.aligned = true;
  EXPECT_FALSE(corrected.allow(settings));
  correction.sensors["left"].delay = 0.1;
  EXPECT_TRUE(corrected.allow(settings));
  correction.sensors.clear();
  correction.hides_ids = true;
  EXPECT_TRUE(corrected.allow(settings));
  corrected.had_no_ids = true;
  EXPECT_FALSE(corrected.allow(settings)) << "as in the map before";
}

using Measuring = ScratchFolder;

TEST_F(Measuring, NeedsLogsThatCanBeReadAgainAndNothingElseWritten) {
  ReplaySettings settings;
  settings.robots.resize(1);
  settings.robots[0].rawlog = write("a.rawlog", "");
  settings.robots[0].source.noise = NoiseSource::kAuto;
  ReplayRequest request;
  EXPECT_TRUE(may_measure(request, settings));
  settings.robots[0].source.noise = NoiseSource::kStated;
  EXPECT_FALSE(may_measure(request, settings));
  settings.robots[0].source.noise = NoiseSource::kAuto;
  settings.robots[0].rawlog = "-";
  EXPECT_FALSE(may_measure(request, settings));
  settings.robots[0].rawlog = at("none.rawlog");
  EXPECT_FALSE(may_measure(request, settings));
  settings.robots[0].rawlog = at("a.rawlog");
  settings.map.file = at("a.hmap");
  EXPECT_FALSE(may_measure(request, settings));
  settings.map.file = "";
  request.stream = true;
  EXPECT_FALSE(may_measure(request, settings));
  request.stream = false;
  request.resume = true;
  EXPECT_FALSE(may_measure(request, settings));
}

}  // namespace
}  // namespace hybrid
