// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>
#include <mrpt/math/CQuaternion.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "libhybrid/core/infinity.h"
#include "mrpt_plugins/output/closure_csv.h"
#include "mrpt_plugins/output/landmark_writer.h"
#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/output/trajectory_writer.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

Trajectory sample_trajectory() {
  return {{1571493463.123456, CPose3D(1.0 / 3, -2e-17, 1e5, 3.0, -1.2, 2.5)},
          {1571493463.25, CPose3D(-4, 5, 6, -3.1, 0.7, -2.9)}};
}

std::vector<std::vector<double>> numbers(const std::string& text) {
  std::vector<std::vector<double>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line[0] == '#') continue;
    std::istringstream in(line);
    rows.emplace_back();
    for (double v = 0; in >> v;) rows.back().push_back(v);
  }
  return rows;
}

TEST(TrajectoryWriter, TumReadsBackToTheSamePoses) {
  const Trajectory written = sample_trajectory();
  const auto rows = numbers(tum_text(written));
  ASSERT_EQ(rows.size(), written.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_EQ(rows[i].size(), 8u);
    EXPECT_EQ(rows[i][0], written[i].time);
    EXPECT_EQ(rows[i][1], written[i].pose.x());
    EXPECT_EQ(rows[i][2], written[i].pose.y());
    EXPECT_EQ(rows[i][3], written[i].pose.z());
    EXPECT_GE(rows[i][7], 0);
    const mrpt::math::CQuaternionDouble q(rows[i][7], rows[i][4], rows[i][5], rows[i][6]);
    const CPose3D read(q, rows[i][1], rows[i][2], rows[i][3]);
    const auto difference = read.getRotationMatrix() - written[i].pose.getRotationMatrix();
    EXPECT_LT(difference.maxCoeff() - difference.minCoeff(), 1e-14);
  }
}

TEST(ClosureCsv, TellsADecisionInNumbersThatReadBack) {
  ClosureDecision decision;
  decision.accept(true);
  decision.inlier_probability = 1.0 / 3;
  decision.chi_square = 2.25;
  decision.redundancy = 0.05;
  decision.checkable = false;
  decision.margin = -kInfinity;  // beyond every gate
  EXPECT_STREQ(kDecisionColumns,
               "decision,inlier_probability,residual,redundancy,checkable,margin");
  EXPECT_EQ(decision_cells(decision), "accepted,0.3333333333333333,1.5,0.05,0,-1000");
  decision.accept(false);
  EXPECT_EQ(decision_cells(decision).substr(0, 9), "rejected,");
  EXPECT_EQ(decision_cells(ClosureDecision::trusted()), "trusted,1,0,1,1,0");
}

MapResult sample_map() {
  MapResult map;
  map.is_3d = true;
  map.class_names = {"tree", "pole, \"steel\""};
  LandmarkEstimate a;
  a.id = 7;
  a.is_3d = true;
  a.position = {1.5, -2.25, 0.125};
  a.covariance << 4, 1, 0.5, 1, 3, 0.25, 0.5, 0.25, 2;
  a.class_index = 1;
  a.class_probabilities = {0.25, 0.75};
  a.sightings = 12;
  a.size = {0.4, 3};
  LandmarkEstimate b;
  b.id = -1;
  b.position = {std::nan(""), 2, 0};
  map.landmarks = {a, b};
  return map;
}

TEST(LandmarkWriter, CsvHasTheStatedColumns) {
  EXPECT_EQ(
      landmarks_csv(sample_map()),
      "id,x,y,z,cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz,class,sightings,extent_m,things,p_tree,"
      "\"p_pole, \"\"steel\"\"\"\n"
      "7,1.5,-2.25,0.125,4,1,0.5,3,0.25,2,\"pole, \"\"steel\"\"\",12,0.4,3,0.25,0.75\n"
      "-1,nan,2,0,0,0,0,0,0,0,,0,0,1,,\n");
}

TEST(LandmarkWriter, JsonHoldsTheSameAndNullForWhatIsNotFinite) {
  const auto json = nlohmann::json::parse(landmarks_json(sample_map()));
  EXPECT_EQ(json["dimension"], 3);
  EXPECT_EQ(json["classes"].size(), 2u);
  const auto& a = json["landmarks"][0];
  EXPECT_EQ(a["id"], 7);
  EXPECT_EQ(a["position"], nlohmann::json({1.5, -2.25, 0.125}));
  EXPECT_EQ(a["covariance"][2], nlohmann::json({0.5, 0.25, 2.0}));
  EXPECT_EQ(a["class"], "pole, \"steel\"");
  EXPECT_EQ(a["class_probabilities"]["tree"], 0.25);
  EXPECT_EQ(a["sightings"], 12);
  EXPECT_EQ(a["extent_m"], 0.4);
  EXPECT_EQ(a["things"], 3);
  const auto& b = json["landmarks"][1];
  EXPECT_EQ(b["position"].size(), 2u);
  EXPECT_TRUE(b["position"][0].is_null());
  EXPECT_TRUE(b["class"].is_null());
}

TEST(LandmarkWriter, RefusesClassesThatDoNotFit) {
  MapResult map = sample_map();
  map.landmarks[0].class_index = 2;
  EXPECT_THROW(landmarks_csv(map), std::invalid_argument);
  map = sample_map();
  map.landmarks[0].class_probabilities = {1.0};
  EXPECT_THROW(landmarks_json(map), std::invalid_argument);
}

TEST(Summary, StatisticsOfAHandComputedCase) {
  std::vector<StepRecord> steps(5);
  const double ms[] = {50, 10, 40, 20, 30};
  for (int i = 0; i < 5; ++i) steps[i].seconds = 1e-3 * ms[i];
  const StepStatistics s = step_statistics(steps);
  EXPECT_DOUBLE_EQ(s.total_s, 0.15);
  EXPECT_DOUBLE_EQ(s.mean_ms, 30);
  EXPECT_DOUBLE_EQ(s.p50_ms, 30);
  EXPECT_DOUBLE_EQ(s.p95_ms, 48);
  EXPECT_DOUBLE_EQ(s.p99_ms, 49.6);
  EXPECT_DOUBLE_EQ(s.max_ms, 50);
  EXPECT_EQ(step_statistics({}).max_ms, 0);
  EXPECT_EQ(plugin_statistics(steps).max_ms, 0);
  steps[2].plugin_ms = 5;
  EXPECT_DOUBLE_EQ(plugin_statistics(steps).mean_ms, 1);
  EXPECT_DOUBLE_EQ(step_statistics(steps).mean_ms, 30);
}

TEST(Summary, JsonHasTheFieldsThatScriptsRead) {
  Summary s;
  s.mode = "incremental";
  s.keyframes = 250;
  s.objective = std::numeric_limits<double>::infinity();
  s.dropped["NaN range"] = 3;
  s.plugins.p95_ms = 1.5;
  s.statistics["updates_by_local_search"] = 2;
  s.warnings = {"no EGL device"};
  s.truth.emplace();
  s.truth->trajectory.emplace();
  s.truth->trajectory->unaligned.rmse_m = 0.25;
  s.truth->trajectory->aligned.max_m = std::nan("");
  s.truth->landmarks.emplace();
  s.truth->landmarks->matched = 70;
  s.truth->class_accuracy = 0.75;
  EXPECT_FALSE(summary_json(s).contains("fixes"));
  s.fixes.count = 40;
  s.fixes.wrong = 3;
  s.fixes.longest_bias = 12.5;
  const auto json = nlohmann::json::parse(summary_json(s).dump());
  EXPECT_EQ(json["fixes"]["false"], 3);
  EXPECT_EQ(json["fixes"]["longest_bias_s"], 12.5);
  EXPECT_EQ(json["status"], "ok");
  EXPECT_EQ(json["mode"], "incremental");
  EXPECT_EQ(json["keyframes"], 250);
  EXPECT_TRUE(json["objective"].is_null());
  for (const char* key : {"landmarks", "path_m", "cost", "solver_s", "total_s"})
    EXPECT_TRUE(json[key] == 0);
  for (const char* key : {"total_s", "mean_ms", "p50_ms", "p95_ms", "p99_ms", "max_ms"}) {
    EXPECT_TRUE(json["steps"].contains(key)) << key;
  }
  EXPECT_EQ(json["plugins"]["p95_ms"], 1.5);
  EXPECT_EQ(json["plugins"]["updates_by_local_search"], 2);
  EXPECT_EQ(json["dropped"]["NaN range"], 3);
  EXPECT_EQ(json["warnings"][0], "no EGL device");
  const auto& truth = json["truth"];
  for (const char* key : {"mean_m", "rmse_m", "max_m", "rotation_mean_deg", "rotation_rmse_deg"}) {
    EXPECT_TRUE(truth["trajectory"].contains(key)) << key;
    EXPECT_TRUE(truth["trajectory"]["aligned"].contains(key)) << key;
  }
  EXPECT_EQ(truth["trajectory"]["rmse_m"], 0.25);
  EXPECT_TRUE(truth["trajectory"]["aligned"]["max_m"].is_null());
  EXPECT_EQ(truth["landmarks"]["matched"], 70);
  EXPECT_EQ(truth["class_accuracy"], 0.75);
  EXPECT_FALSE(truth.contains("nees_pose"));
  EXPECT_FALSE(truth.contains("dead_reckoning"));
}

TEST(Summary, StepsCsvHasOneLinePerStep) {
  StepRecord s;
  s.keyframe = 3;
  s.time = 1.5;
  s.seconds = 0.25e-3;
  s.plugin_ms = 0.125;
  s.rounds = 2;
  s.flips = 1;
  s.relinearized = 4;
  s.objective_after = -7.5;
  s.cost = 0.5;
  s.landmarks = 9;
  s.eliminated = 6;
  s.pending = 2;
  EXPECT_EQ(steps_csv({s}),
            "keyframe,time,solver_ms,iterations,flips,relinearized,objective,cost,landmarks,"
            "plugin_ms,eliminated,pending\n"
            "3,1.5,0.25,2,1,4,-7.5,0.5,9,0.125,6,2\n");
}

}  // namespace
}  // namespace hybrid
