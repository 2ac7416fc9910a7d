// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/simulation/receiver.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/evaluation/mode_truth.h"
#include "mrpt_plugins/input/fixes.h"
#include "mrpt_plugins/simulation/robot_path.h"
#include "mrpt_plugins/simulation/simulator.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

Scenario with_receiver(const std::string& text) {
  IniFile ini(text, "scenario.ini");
  const Scenario scenario = read_scenario(ini);
  ini.reject_unknown();
  return scenario;
}

/// Seventeen hours in a circle, a frame each ten seconds, and a fix each second.
std::vector<SimulatedFix> long_drive(const std::string& errors) {
  const Scenario scenario = with_receiver(
      "[path]\nradius = 100\nlaps = 100\nstep = 10\nperiod = 10\n[fixes]\nperiod = 1\n" + errors);
  return draw_fixes(scenario, robot_path(scenario.path, scenario.is_3d));
}

struct BiasedRun {
  double begin = 0, end = 0;  // of its first fix and its last
  Eigen::Vector3d bias;
};

TEST(Receiver, RunsAreAsLongAndAsBiasedAsAsked) {
  const auto fixes = long_drive(
      "sigma = 0.001\nlasting_sigma = 0\nbias_every = 100\nbias_min_time = 5\n"
      "bias_max_time = 60\nmin_bias = 2\nmax_bias = 30\n");
  std::vector<BiasedRun> runs;
  for (const SimulatedFix& fix : fixes) {
    if (fix.mode == FixMode::kGood) {
      EXPECT_LT(fix.error.norm(), 0.01);
      continue;
    }
    ASSERT_EQ(fix.mode, FixMode::kBiased);
    const bool goes_on = !runs.empty() && (runs.back().bias - fix.error).norm() < 0.02;
    if (!goes_on) runs.push_back({fix.time, fix.time, fix.error});
    runs.back().end = fix.time;
  }
  double length = 0, size = 0;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  for (const BiasedRun& run : runs) {
    EXPECT_GE(run.end - run.begin, 4 - 1e-6);
    EXPECT_LE(run.end - run.begin, 60 + 1e-6);
    EXPECT_GE(run.bias.norm(), 2 - 0.01);
    EXPECT_LE(run.bias.norm(), 30 + 0.01);
    EXPECT_NEAR(run.bias.z(), 0, 0.01);  // in 2-D
    length += run.end - run.begin;
    size += run.bias.norm();
    direction += run.bias.normalized();
  }
  const auto n = static_cast<double>(runs.size());
  EXPECT_NEAR(n, fixes.size() / (100 + 32.5), 4 * std::sqrt(fixes.size() / 132.5));
  EXPECT_NEAR(length / n, 31.5, 4 * 55 / std::sqrt(12 * n));  // a fix less than in seconds
  EXPECT_NEAR(size / n, 16, 4 * 28 / std::sqrt(12 * n));
  EXPECT_LT(direction.norm() / n, 4 / std::sqrt(n));
}

TEST(Receiver, BiasesWalkAndPointUpwardsInSpace) {
  const Scenario scenario = with_receiver(
      "[simulation]\ndimension = 3d\n[path]\nlaps = 20\n[fixes]\nperiod = 1\nsigma = 0\n"
      "lasting_sigma = 0\nbias_every = 1\nbias_min_time = 50\nbias_walk = 0.1\n");
  const auto fixes = draw_fixes(scenario, robot_path(scenario.path, true));
  double square = 0, up = 0;
  std::size_t count = 0;
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    const Eigen::Vector3d step = fixes[i].error - fixes[i - 1].error;
    up = std::max(up, std::abs(fixes[i].error.z()));
    if (step.norm() > 0.8 || fixes[i].mode == FixMode::kGood) continue;  // another run
    square += step.squaredNorm() / 3;
    ++count;
  }
  ASSERT_GT(count, 300U);
  EXPECT_NEAR(std::sqrt(square / double(count)), 0.1, 0.02);
  EXPECT_GT(up, 2);
}

TEST(Receiver, FalseFixesAreAnywhere) {
  const auto fixes = long_drive("false_share = 0.02\nfalse_reach = 800\n");
  double count = 0, square = 0;
  for (const SimulatedFix& fix : fixes) {
    if (fix.mode != FixMode::kFalse) continue;
    ++count;
    EXPECT_LE(fix.error.cwiseAbs().maxCoeff(), 400);
    square += fix.error.x() * fix.error.x();
  }
  const auto n = static_cast<double>(fixes.size());
  EXPECT_NEAR(count / n, 0.02, 4 * std::sqrt(0.02 * 0.98 / n));
  EXPECT_NEAR(std::sqrt(12 * square / count), 800, 40);
}

TEST(Receiver, WhatLastsIsForgotten) {
  const auto fixes = long_drive("sigma = 0\nlasting_sigma = 2\nlasts = 50\n");
  double square = 0, later = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i + 50 < fixes.size(); ++i, ++count) {
    square += fixes[i].error.head<2>().squaredNorm() / 2;
    later += fixes[i].error.head<2>().dot(fixes[i + 50].error.head<2>()) / 2;
  }
  // Some 1,250 independent numbers.
  EXPECT_NEAR(square / double(count), 4, 4 * 4 * std::sqrt(2.0 / 1250));
  EXPECT_NEAR(later / square, std::exp(-1.0), 0.12);
}

TEST(Receiver, NothingIsReceivedInOutages) {
  const auto fixes = long_drive("outage_every = 300\noutage_min_time = 20\noutage_max_time = 40\n");
  double outages = 0, missing = 0;
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    const double gap = fixes[i].time - fixes[i - 1].time;
    if (gap < 1.5) continue;
    ++outages;
    missing += gap - 1;
    EXPECT_GE(gap, 20);
  }
  EXPECT_NEAR(outages, 62832 / 330.0, 4 * std::sqrt(62832 / 330.0));
  EXPECT_NEAR(missing / outages, 30, 4);
}

TEST(Receiver, AFixIsWhereTheAntennaWasAndItsErrorOff) {
  for (const std::string dimension : {"2d", "3d"}) {
    const Scenario scenario = with_receiver(
        "[simulation]\ndimension = " + dimension +
        "\n[path]\nstart = 5 6 40\nperiod = 0.5\nradius = 10\nheight = 2\nroll_deg = 5\n"
        "[fixes]\nperiod = 0.7\ndelay = 0.3\nantenna = 1 0 2\ndatum = 60 20 100\n"
        "bias_every = 5\nfalse_share = 0.1\n");
    const auto path = robot_path(scenario.path, scenario.is_3d);
    const auto fixes = draw_fixes(scenario, path);
    const LocalFrame world(scenario.fixes.datum);
    ASSERT_GT(fixes.size(), 20U);
    for (std::size_t k = 0; k < fixes.size(); ++k) {
      const SimulatedFix& fix = fixes[k];
      EXPECT_NEAR(fix.time, 0.7 * double(k) + 0.3, 1e-9);
      EXPECT_GE(0.5 * double(fix.frame), fix.time - 1e-6);
      EXPECT_LT(0.5 * double(fix.frame), fix.time + 0.5);
      const Eigen::Vector3d place = world.to_local(fix.place) - fix.error;
      const double at = 1.4 * double(k);  // frames
      const auto i = static_cast<std::size_t>(at + 1e-9);
      const Eigen::Vector3d before = transformed(path[i], {1, 0, 2});
      const Eigen::Vector3d after = transformed(path[std::min(i + 1, path.size() - 1)], {1, 0, 2});
      EXPECT_NEAR((place - before - (at - double(i)) * (after - before)).norm(), 0, 0.01) << k;
      if (at - double(i) < 1e-6) {
        EXPECT_NEAR((place - before).norm(), 0, 1e-3);
      }
    }
  }
}

TEST(Receiver, ChangesNothingElseAndIsTheSameForASeed) {
  const std::string text = "[sensor]\nspurious_per_frame = 0.5\n[movers]\ncount = 2\n";
  const std::string receiver = "[fixes]\nperiod = 1\nbias_every = 10\nfalse_share = 0.1\n";
  const Simulation without = simulate(with_receiver(text));
  const Simulation with = simulate(with_receiver(text + receiver));
  EXPECT_TRUE(without.fixes.empty());
  ASSERT_EQ(with.frames.size(), without.frames.size());
  for (std::size_t i = 0; i < with.frames.size(); ++i) {
    EXPECT_EQ(with.frames[i].motion, without.frames[i].motion);
    ASSERT_EQ(with.frames[i].detections.size(), without.frames[i].detections.size());
    for (std::size_t d = 0; d < with.frames[i].detections.size(); ++d) {
      EXPECT_EQ(with.frames[i].detections[d].range, without.frames[i].detections[d].range);
    }
  }
  const Simulation again = simulate(with_receiver(text + receiver));
  const Simulation other = simulate(with_receiver(text + "[simulation]\nseed = 2\n" + receiver));
  ASSERT_EQ(again.fixes.size(), with.fixes.size());
  for (std::size_t k = 0; k < with.fixes.size(); ++k) {
    EXPECT_EQ(again.fixes[k].error, with.fixes[k].error);
    EXPECT_EQ(again.fixes[k].place.latitude, with.fixes[k].place.latitude);
  }
  EXPECT_NE(other.fixes[0].error, with.fixes[0].error);
}

TEST(Receiver, LogAndTruthHaveTheSameFixes) {
  const Scenario scenario = with_receiver(
      "[fixes]\nperiod = 0.4\nantenna = 0.5 0 1\nbias_every = 5\nfalse_share = 0.2\n"
      "stated_quality = 2\nstated_sigma = 0.7\n");
  const Simulation simulation = simulate(scenario);
  const TemporaryFile log("received.rawlog"), map("received_ground_truth.txt"),
      path("received_ground_truth_robot_path.txt"), truth("received_ground_truth_fixes.csv");
  EXPECT_EQ(write_simulation(simulation, scenario, log.path()).size(), 4U);
  const auto rows = read_true_fixes(truth.path());
  ASSERT_EQ(rows.size(), simulation.fixes.size());
  RawlogReader reader(log.path(), {});
  std::size_t k = 0;
  DropReport dropped;
  while (const auto step = reader.next()) {
    for (const auto& observation : step->observations) {
      const auto fix = fix_in(*observation, dropped);
      if (!fix) continue;
      ASSERT_LT(k, rows.size());
      EXPECT_NEAR(fix->fix.time, rows[k].time, 1e-5);
      EXPECT_EQ(rows[k].mode, simulation.fixes[k].mode);
      EXPECT_NEAR(fix->fix.sigma, 0.7, 1e-6);
      EXPECT_NEAR(fix->fix.antenna.z(), 1, 1e-6);
      EXPECT_NEAR(fix->place.latitude, simulation.fixes[k].place.latitude, 1e-12);
      ++k;
    }
  }
  EXPECT_EQ(k, rows.size());
  EXPECT_TRUE(dropped.empty());
}

TEST(Receiver, RefusesWhatNoneIs) {
  for (const std::string keys :
       {"period = -1\n", "period = 1\ndatum = 95 0 0\n", "datum = 1 2\n", "antenna = 1\n",
        "bias_min_time = 9\nbias_max_time = 8\n", "min_bias = 9\nmax_bias = 8\n",
        "false_share = 2\n", "delay = -1\n", "stated_quality = 9\n", "nothing = 1\n"}) {
    EXPECT_THROW(with_receiver("[fixes]\n" + keys), Error) << keys;
  }
  EXPECT_THROW(with_receiver("[simulation]\nformat = observations\n[fixes]\nperiod = 1\n"), Error);
  EXPECT_NO_THROW(with_receiver("[world]\nlandmarks = 0\n[fixes]\nperiod = 1\n"));
}

}  // namespace
}  // namespace hybrid
