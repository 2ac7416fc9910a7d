// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/simulation/laser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/input/keyframe_source.h"
#include "mrpt_plugins/simulation/simulator.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

/// Rays at -90, -45, 0, 45 and 90 degrees in a room of 4 m x 3 m whose corner is the origin.
Scenario::Laser room() {
  Scenario::Laser laser;
  laser.rays = 5;
  laser.fov = M_PI;
  laser.max_range = 20;
  laser.walls = {{0, 0, 4, 0}, {4, 0, 4, 3}, {4, 3, 0, 3}, {0, 3, 0, 0}};
  return laser;
}

const mrpt::poses::CPose3D kInRoom(1, 1, 0, 0, 0, 0);

std::vector<float> seen(const Scenario::Laser& laser, std::uint64_t seed = 1,
                        const std::vector<SimulatedMover>& movers = {}) {
  Random random(seed);
  return simulated_scan(laser, kInRoom, movers, 0, random);
}

TEST(SimulatedLaser, RaysEndAtWalls) {
  const auto ranges = seen(room());
  ASSERT_EQ(ranges.size(), 5U);
  EXPECT_NEAR(ranges[0], 1, 1e-6);
  EXPECT_NEAR(ranges[1], std::sqrt(2), 1e-6);
  EXPECT_NEAR(ranges[2], 3, 1e-6);
  EXPECT_NEAR(ranges[3], 2 * std::sqrt(2), 1e-6);
  EXPECT_NEAR(ranges[4], 2, 1e-6);
  Scenario::Laser near = room();
  near.max_range = 2.5;
  EXPECT_EQ(seen(near)[2], 0) << "nothing is seen at the maximum range";
  near.walls.clear();
  EXPECT_EQ(seen(near), std::vector<float>(5, 0.0F));
}

TEST(SimulatedLaser, NoiseGlassAndPeople) {
  Scenario::Laser laser = room();
  laser.rays = 1;
  laser.sigma_range = 0.05;
  laser.glass = {{2, 0, 2, 3}};
  laser.glass_seen = 0.25;
  int glass = 0;
  double sum = 0, squares = 0;
  constexpr int kScans = 2000;
  for (int i = 0; i < kScans; ++i) {
    const double range = seen(laser, static_cast<std::uint64_t>(i)).at(0);
    const bool at_glass = range < 2;
    glass += at_glass ? 1 : 0;
    const double error = range - (at_glass ? 1 : 3);
    sum += error;
    squares += error * error;
  }
  EXPECT_NEAR(glass, 0.25 * kScans, 80);
  EXPECT_NEAR(sum / kScans, 0, 0.005);
  EXPECT_NEAR(std::sqrt(squares / kScans), 0.05, 0.003);
  laser.sigma_range = 0;
  laser.person_radius = 0.25;
  SimulatedMover person;
  person.path = {{1.8, 1, 0}};
  EXPECT_NEAR(seen(laser, 1, {person})[0], 0.55, 1e-6);
  person.path = {{1.8, 1.3, 0}};
  EXPECT_GT(seen(laser, 1, {person})[0], 0.9) << "beside the ray";
}

Scenario scenario_from(IniFile& ini) {
  const Scenario scenario = read_scenario(ini);
  ini.reject_unknown();
  return scenario;
}

TEST(SimulatedLaser, ALogOfScansIsReadAsItWasMade) {
  IniFile ini{std::filesystem::path(HYBRID_SOURCE_DIR "/config/simulate_rooms.ini")};
  Scenario scenario = scenario_from(ini);
  scenario.path.laps = 1;
  scenario.path.step = 1;
  const Simulation simulation = simulate(scenario);
  for (const bool pairs : {true, false}) {
    scenario.pairs = pairs;
    const TemporaryFile log("rooms.rawlog"), map("rooms_ground_truth.txt"),
        path("rooms_ground_truth_robot_path.txt"), movers("rooms_ground_truth_movers.csv");
    write_simulation(simulation, scenario, log.path());
    KeyframeSource source(log.path(), {});
    std::size_t frames = 0;
    while (const auto keyframe = source.next()) {
      ASSERT_EQ(keyframe->scans.size(), 1U);
      EXPECT_TRUE(keyframe->detections.empty());
      const LaserScan& scan = keyframe->scans[0];
      const std::vector<float>& made = simulation.frames.at(frames).scan;
      ASSERT_EQ(scan.ranges.size(), made.size());
      for (std::size_t i = 0; i < made.size(); ++i) {
        EXPECT_TRUE(made[i] > 0 ? scan.ranges[i] == made[i] : std::isnan(scan.ranges[i]));
      }
      EXPECT_NEAR(scan.T_robot_sensor.translation().x(), 0.2, 1e-9);
      ++frames;
    }
    EXPECT_EQ(frames, simulation.frames.size());
  }
  // The rooms are equal: where the robot stands in one and in the other, it sees the same.
  const auto at = [&](double x, double y) {
    Scenario::Laser laser = scenario.laser;
    laser.sigma_range = 0;
    laser.glass_seen = 0;
    Random random(1);
    return simulated_scan(laser, {x, y, 0, 1.6, 0, 0}, {}, 0, random);
  };
  const auto first = at(7, 3), second = at(21, 3);
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_NEAR(first[i], second[i], 1e-5) << i;
}

TEST(SimulatedLaser, ALaserChangesNothingElse) {
  IniFile ini{std::filesystem::path(HYBRID_SOURCE_DIR "/config/simulate_movers_demo.ini")};
  Scenario scenario = scenario_from(ini);
  const Simulation without = simulate(scenario);
  scenario.laser = room();
  const Simulation with = simulate(scenario);
  ASSERT_EQ(with.frames.size(), without.frames.size());
  for (std::size_t i = 0; i < with.frames.size(); ++i) {
    EXPECT_EQ(with.frames[i].motion, without.frames[i].motion);
    EXPECT_EQ(with.frames[i].detections.size(), without.frames[i].detections.size());
  }
}

TEST(SimulatedLaser, WrongFloorPlansAreRefused) {
  const auto refused = [](const std::string& text, const std::string& part) {
    IniFile ini(text, "plan.ini");
    try {
      read_scenario(ini);
      ADD_FAILURE() << text;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  };
  refused("[laser]\nrays = 5\nwalls = 1 2 3\n", "needs four numbers for each");
  refused("[world]\nlandmarks = 0\n", "nothing is seen");
  refused("[simulation]\ndimension = 3d\n[laser]\nrays = 5\n", "must be 0 in 3d");
  refused("[laser]\npose = 1 2\n", "three numbers");
}

}  // namespace
}  // namespace hybrid
