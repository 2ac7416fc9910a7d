// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "mrpt_plugins/report/columns.h"
#include "mrpt_plugins/report/fix_json.h"
#include "mrpt_plugins/report/graph_report.h"
#include "mrpt_plugins/report/history_json.h"
#include "mrpt_plugins/report/page.h"
#include "mrpt_plugins/report/scan_json.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

std::size_t count(std::string_view text, std::string_view part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++n;
  return n;
}

// What the page asks for from outside would be a request.
TEST(ReportPage, HoldsOnePlaceForDataAndNamesNothingOutside) {
  EXPECT_EQ(count(report_template(), "<!-- data -->"), 1u);
  EXPECT_EQ(count(report_template(), " src="), 0u);
  EXPECT_EQ(count(report_template(), "@import"), 0u);
  EXPECT_EQ(count(report_template(), "default-src 'none'"), 1u);
  EXPECT_LE(report_template().size(), 300000u);
}

TEST(ReportPage, TakesTextsThatWouldEndItsScript) {
  const std::string page = report_page({{"title", "</script><b>"}});
  EXPECT_EQ(count(page, "</script><b>"), 0u);
  EXPECT_EQ(count(page, "<!-- data -->"), 0u);
  EXPECT_EQ(count(page, ">H4sI"), 1u);  // base 64 of gzip's first bytes
}

TEST(ReportPage, IsTheSameEveryTime) {
  EXPECT_EQ(report_page({{"a", 1}}), report_page({{"a", 1}}));
}

TEST(ReportColumns, RoundToWhatOneCanSee) {
  EXPECT_EQ(digits(123456.0), 123456.0);
  EXPECT_EQ(digits(1.23456789), 1.235);
  EXPECT_EQ(digits(-0.00123456), -0.001235);
  EXPECT_EQ(digits(0.0), 0);
  EXPECT_TRUE(digits(std::nan("")).is_null());
  EXPECT_TRUE(decimals(std::numeric_limits<double>::infinity()).is_null());
  EXPECT_EQ(decimals(1.23456), 1.2346);
}

TEST(ReportColumns, StepsAddUpToWithinHalfAUnit) {
  const std::vector<double> values = {-3.2, 7.7, 7.7, 0.1, 1000.4};
  const Json steps = steps_of(values, -3.2, 0.5);
  long sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += steps[i].get<long>();
    EXPECT_NEAR(-3.2 + 0.5 * static_cast<double>(sum), values[i], 0.25 + 1e-12);
  }
}

TEST(ReportHistory, LeavesOutFramesThatCouldBeSeenInOneWayOnly) {
  RunRecord record;
  record.associations.push_back({3, {{}, {0}, {{{5}, 0.0}}, false}});
  record.associations.push_back({4, {{}, {1}, {{{5}, 0.0}, {{std::nullopt}, -2.0}}, true}});
  const Json shown = history_json(record, false).at("associations");
  ASSERT_EQ(shown.size(), 1u);
  EXPECT_EQ(shown[0].at("k"), 4);
  EXPECT_TRUE(shown[0].at("hypotheses")[1][0][0].is_null());
}

TEST(ReportHistory, OfAnEmptyRunIsEmpty) {
  const Json empty = history_json({}, true);
  EXPECT_TRUE(empty.at("sightings").at("k").empty());
  EXPECT_TRUE(empty.at("snapshots").at("list").empty());
}

TEST(ReportFixes, AreThinnedWithinEachMode) {
  MapResult map;
  for (int i = 0; i < 1000; ++i) {
    FixEstimate fix;
    fix.keyframe = static_cast<std::size_t>(i);
    fix.measured = {1.0 * i, 2, 0};
    if (i % 100 != 7) fix.mode = i % 100 == 50 ? FixMode::kFalse : FixMode::kGood;
    if (i == 0) fix.probabilities = {0.9, 0.09876, 0.00124};
    map.fixes.push_back(fix);
  }
  EXPECT_TRUE(fixes_json(map, 100).at("k").empty());  // where they are is not known
  map.datum = MapDatum();
  const Json fixes = fixes_json(map, 100);
  EXPECT_EQ(fixes.at("counts"), Json({980, 0, 10, 10}));
  std::map<int, int> kept;
  for (const auto& mode : fixes.at("mode")) ++kept[mode.get<int>()];
  EXPECT_EQ(kept[2], 10);
  EXPECT_EQ(kept[3], 10);
  EXPECT_LE(kept[0], 100);
  EXPECT_GT(kept[0], 50);
  for (const char* column : {"k", "x", "y", "ax", "ay", "p"}) {
    EXPECT_EQ(fixes.at(column).size(), fixes.at("mode").size()) << column;
  }
  EXPECT_EQ(fixes.at("p")[0], Json({0.9, 0.099, 0.001}));
  EXPECT_TRUE(fixes.at("p")[1].empty());
}

TEST(ReportClouds, WallsAreInALevelFrameWithTheHeadingOfTheirAnchor) {
  // A robot that is turned by 90 degrees and tilted by 30 about its own x axis.
  const Eigen::AngleAxisd tilt(M_PI / 6, Eigen::Vector3d::UnitX());
  const mrpt::poses::CPose3D pose(1, 2, 3, M_PI / 2, 0, M_PI / 6);
  LocalView view;
  view.anchor = 1;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d wall(2, 0.1 * i, 0.5);
    CloudPoint point;
    point.position = (tilt.inverse() * wall).cast<float>();
    point.normal = Eigen::Vector3f(-1, 0, 0);
    view.points.push_back(point);
    point.position = (tilt.inverse() * Eigen::Vector3d(0, 0.1 * i, -1)).cast<float>();
    point.normal = (tilt.inverse() * Eigen::Vector3d::UnitZ()).cast<float>();
    view.points.push_back(point);  // of the floor, which is left out
  }
  const Trajectory path = {{0, mrpt::poses::CPose3D()}, {1, pose}};
  const Json all = views_json({view}, path);
  ASSERT_EQ(all["list"].size(), 1U);
  EXPECT_EQ(all["list"][0]["k"], 1);
  EXPECT_EQ(all["list"][0]["x"].size(), 100U);
  EXPECT_EQ(all["list"][0]["x"][0], 200);
  EXPECT_EQ(all["list"][0]["y"][1], 10);
  EXPECT_EQ(all["list"][0]["z"][0], 50);
  EXPECT_LE(views_json({view}, path, 30)["list"][0]["x"].size(), 30U);
}

TEST(TrialsReport, ReadsNumbersAndKeepsNames) {
  const Json page = trials_report_json("t", "method,seed,seconds,message\nlm,1,0.5,\n", {});
  EXPECT_EQ(page.at("columns").size(), 4u);
  ASSERT_EQ(page.at("rows").size(), 1u);
  EXPECT_EQ(page.at("rows")[0][0], "lm");
  EXPECT_EQ(page.at("rows")[0][2], 0.5);
  EXPECT_EQ(page.at("rows")[0][3], "");
}

}  // namespace
}  // namespace hybrid
