// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/simulation/simulator.h"

#include <gtest/gtest.h>
#include <mrpt/math/CMatrixDynamic.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/evaluation/ground_truth.h"
#include "mrpt_plugins/input/detections.h"
#include "mrpt_plugins/simulation/random.h"
#include "mrpt_plugins/simulation/robot_path.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

Scenario scenario_of(const std::string& text) {
  IniFile ini(text, "scenario.ini");
  const Scenario scenario = read_scenario(ini);
  ini.reject_unknown();
  return scenario;
}

/// A simulated log and its truth, removed at the end.
class Simulated {
 public:
  explicit Simulated(const std::string& ini)
      : scenario(scenario_of(ini)),
        simulation(simulate(scenario)),
        log("simulated.rawlog"),
        landmarks("simulated_ground_truth.txt"),
        path("simulated_ground_truth_robot_path.txt") {
    write_simulation(simulation, scenario, log.path());
  }
  std::vector<LogStep> steps(const RawlogOptions& options = {}) const {
    RawlogReader reader(log.path(), options);
    std::vector<LogStep> all;
    while (auto step = reader.next()) all.push_back(*step);
    EXPECT_EQ(reader.status(), LogStatus::kComplete) << reader.message();
    return all;
  }
  const Scenario scenario;
  const Simulation simulation;
  const TemporaryFile log, landmarks, path;
};

TEST(Simulator, CommittedLogsComeOutByteForByte) {
  const std::string root = HYBRID_SOURCE_DIR;
  for (const std::string name : {"classed_demo", "classed_demo_3d", "slip_demo", "calibration_demo",
                                 "movers_demo", "fixes_demo"}) {
    IniFile ini{std::filesystem::path(root + "/config/simulate_" + name + ".ini")};
    const Scenario scenario = read_scenario(ini);
    ini.reject_unknown();
    const TemporaryFile log("again.rawlog"), landmarks("again_ground_truth.txt"),
        path("again_ground_truth_robot_path.txt");
    const auto files = write_simulation(simulate(scenario), scenario, log.path());
    std::vector<std::string> suffixes{".rawlog", "_ground_truth.txt",
                                      "_ground_truth_robot_path.txt"};
    if (name == "slip_demo") suffixes.emplace_back("_ground_truth_modes.txt");
    if (name == "movers_demo") suffixes.emplace_back("_ground_truth_movers.csv");
    if (name == "fixes_demo") suffixes.emplace_back("_ground_truth_fixes.csv");
    ASSERT_EQ(files.size(), suffixes.size());
    for (const std::string& suffix : suffixes) {
      const std::string stem = log.path().substr(0, log.path().size() - 7);
      EXPECT_TRUE(read_bytes(stem + suffix) == read_bytes(root + "/rawlogs/" + name + suffix))
          << name << suffix;
    }
    EXPECT_LT(std::filesystem::file_size(root + "/rawlogs/" + name + ".rawlog"), 300'000U);
  }
}

TEST(Simulator, MoversKeepTheirSpeedWithinTheWalls) {
  const Scenario scenario = scenario_of(
      "[world]\nlandmarks = 4\nmin_corner = -12 -5 0\nmax_corner = 12 20 0\n"
      "[movers]\ncount = 3\nspeed = 2\nacceleration = 0\n[path]\nlaps = 3\n");
  const Simulation s = simulate(scenario);
  ASSERT_EQ(s.movers.size(), 3U);
  std::size_t seen = 0;
  for (std::size_t m = 0; m < s.movers.size(); ++m) {
    const SimulatedMover& mover = s.movers[m];
    EXPECT_EQ(mover.id, static_cast<std::int64_t>(4 + m));
    ASSERT_EQ(mover.path.size(), s.frames.size());
    for (std::size_t i = 1; i < mover.path.size(); ++i) {
      const auto& a = mover.path[i - 1];
      const auto& b = mover.path[i];
      EXPECT_LE(std::hypot(b[0] - a[0], b[1] - a[1]), 2 * scenario.path.period + 1e-6);
      EXPECT_LE(std::abs(b[0]), 12 + 1e-6);
      EXPECT_TRUE(b[1] >= -5 - 1e-6 && b[1] <= 20 + 1e-6);
    }
  }
  for (const SimulatedFrame& frame : s.frames) {
    for (const SimulatedDetection& d : frame.detections) {
      EXPECT_EQ(d.moves, d.true_id >= 4);
      seen += d.moves;
    }
  }
  EXPECT_GT(seen, 0U);
}

TEST(Simulator, WheelsSlipAndErrAsStated) {
  const Scenario scenario = scenario_of(
      "[path]\nlaps = 20\n[slip]\nstart = 0.1\nstay = 0.5\nmin_share = 0.5\nmax_share = 0.5\n"
      "sigma_yaw_deg = 0\n[odometry]\nsigma_translation = 1e-6\nsigma_yaw_deg = 1e-5\n"
      "scale_translation = 0.8\nscale_rotation = 1.25\ndrift_deg_per_m = 1\n");
  const Simulation s = simulate(scenario);
  double slips = 0;
  for (std::size_t i = 1; i < s.frames.size(); ++i) {
    const SimulatedFrame& frame = s.frames[i];
    const mrpt::poses::CPose3D motion = s.path[i] - s.path[i - 1];
    slips += frame.slips;
    const double measured = std::hypot(frame.motion[0], frame.motion[1]);
    EXPECT_NEAR(0.8 * (frame.slips ? 0.5 : 1.0) * measured, motion.norm(), 1e-5);
    EXPECT_NEAR(1.25 * frame.motion[3] + measured * M_PI / 180, motion.yaw(), 1e-5);
  }
  EXPECT_NEAR(slips / double(s.frames.size() - 1), 1.0 / 6, 0.04);
}

TEST(Simulator, NoiseIsAsStated) {
  for (const std::string dimension : {"2d", "3d"}) {
    const Simulated s("[simulation]\ndimension = " + dimension +
                      "\n[world]\nlandmarks = 40\nmin_spacing = 0.5\n"
                      "[path]\nlaps = 6\nheight = 2\nroll_deg = 5\n"
                      "[sensor]\npose = 0.5 0.2 0 20 0 0\n");
    const auto path = read_true_path(s.path.path());
    const auto landmarks = read_true_landmarks(s.landmarks.path());
    const auto steps = s.steps();
    ASSERT_EQ(steps.size(), path.size());
    EXPECT_EQ(path[0].distanceTo(mrpt::poses::CPose3D()), 0);
    double odometry = 0, measurements = 0;
    std::size_t motions = 0, detections = 0;
    DropReport dropped;
    for (const LogStep& step : steps) {
      if (step.index > 0) {
        ASSERT_TRUE(step.odometry);
        EXPECT_EQ(step.odometry->is_planar, dimension == "2d");
        const auto error = path[step.index] - (path[step.index - 1] + step.odometry->mean);
        EXPECT_NEAR(step.odometry->covariance(0, 0), 0.03 * 0.03, 1e-6);
        EXPECT_NEAR(step.odometry->covariance(5, 5), std::pow(0.3 * M_PI / 180, 2), 1e-6);
        odometry += error.x() * error.x() / step.odometry->covariance(0, 0) +
                    error.yaw() * error.yaw() / step.odometry->covariance(5, 5);
        motions += 2;
      }
      const auto frame = detections_in(*step.observations.at(0), {}, dropped);
      ASSERT_TRUE(frame);
      EXPECT_EQ(frame->is_3d, dimension == "3d");
      for (const Detection& d : frame->detections) {
        ASSERT_TRUE(d.id);
        EXPECT_EQ(d.id, d.true_id);
        const auto& p = landmarks.at(static_cast<std::size_t>(*d.id)).position;
        double range = 0, yaw = 0, pitch = 0;
        (path[step.index] + to_mrpt(frame->T_robot_sensor))
            .sphericalCoordinates({p.x(), p.y(), p.z()}, range, yaw, pitch);
        measurements += std::pow(range - d.range, 2) / d.covariance(0, 0) +
                        std::pow(yaw - d.yaw, 2) / d.covariance(1, 1);
        detections += 2;
      }
    }
    // Mean of n squared standard normals: 1 with deviation sqrt(2 / n).
    EXPECT_NEAR(odometry / static_cast<double>(motions), 1, 4 * std::sqrt(2.0 / motions));
    EXPECT_NEAR(measurements / static_cast<double>(detections), 1, 4 * std::sqrt(2.0 / detections));
    EXPECT_TRUE(dropped.empty());
  }
}

TEST(Simulator, DetectorFollowsItsConfusionMatrixAndScoresArePosteriors) {
  const Simulated s(
      "[world]\nlandmarks = 30\nclasses = a b\n[path]\nlaps = 10\n"
      "[sensor]\ndetection_probability = 0.8\nspurious_per_frame = 0.5\n"
      "[detector]\nconfusion = 0.9 0.1 0.3 0.7\n");
  double counts[2][2] = {};
  double spurious = 0;
  for (const auto& frame : s.simulation.frames) {
    for (const auto& d : frame.detections) {
      if (d.true_id < 0)
        ++spurious;
      else
        ++counts[d.true_id % 2][d.reported_class];
    }
  }
  const double a = counts[0][0] + counts[0][1], b = counts[1][0] + counts[1][1];
  EXPECT_NEAR(counts[0][0] / a, 0.9, 4 * std::sqrt(0.09 / a));
  EXPECT_NEAR(counts[1][1] / b, 0.7, 4 * std::sqrt(0.21 / b));
  const auto frames = static_cast<double>(s.simulation.frames.size());
  EXPECT_NEAR(spurious / frames, 0.5, 4 * std::sqrt(0.5 / frames));
  const auto scores = class_scores(s.scenario.sensor.confusion, 0);
  EXPECT_NEAR(scores[0], 0.9 / 1.2, 1e-6);
  EXPECT_NEAR(scores[1], 0.3 / 1.2, 1e-6);
}

TEST(Simulator, HiddenIdsPlainObservationsAndObservationFormat) {
  const Simulated hidden("[sensor]\nids = hidden\nspurious_per_frame = 1\n");
  DropReport dropped;
  std::size_t known = 0;
  for (const auto& step : hidden.steps()) {
    const auto frame = detections_in(*step.observations.at(0), {}, dropped);
    for (const Detection& d : frame->detections) {
      EXPECT_FALSE(d.id);
      known += d.true_id ? 1 : 0;
    }
  }
  EXPECT_GT(known, 0U);

  const Simulated plain("[simulation]\nobservation = plain\nformat = observations\n");
  const auto steps = plain.steps();
  EXPECT_EQ(steps.size(), plain.simulation.frames.size());
  for (const auto& step : steps) {
    ASSERT_EQ(step.observations.size(), 1U);
    EXPECT_TRUE(
        std::dynamic_pointer_cast<mrpt::obs::CObservationBearingRange>(step.observations[0]));
    if (step.index == 0) continue;
    const auto& m = plain.simulation.frames[step.index].motion;
    ASSERT_TRUE(step.odometry);
    EXPECT_NEAR(step.odometry->mean.distanceTo(mrpt::poses::CPose3D(m[0], m[1], 0, m[3], 0, 0)), 0,
                1e-6);
  }
}

TEST(Simulator, SeedsDiffer) {
  const auto one = simulate(scenario_of("[simulation]\nseed = 1\n"));
  const auto two = simulate(scenario_of("[simulation]\nseed = 2\n"));
  EXPECT_NE(one.landmarks[0].position, two.landmarks[0].position);
}

TEST(Simulator, TruthTablesLoadInMrpt) {
  const Simulated s("[world]\nlandmarks = 8\n");
  mrpt::math::CMatrixDouble table;
  table.loadFromTextFile(s.landmarks.path());
  EXPECT_EQ(table.rows(), 8);
  EXPECT_EQ(table.cols(), 8);
  EXPECT_EQ(read_true_landmarks(s.landmarks.path())[1].class_name, "car");
}

TEST(Simulator, RefusesWhatCannotBe) {
  for (const std::string ini :
       {"[world]\nmin_spacing = 50\n", "[simulation]\ndimension = 3d\nformat = observations\n",
        "[path]\nshape = waypoints\n", "[path]\nshape = waypoints\nwaypoints = 1 2 3\n",
        "[detector]\nconfusion = 1 0\n",
        "[world]\nclasses = a b\n[detector]\nconfusion = 1 1 0 1\n", "[sensor]\nmin_range = 9\n",
        "[sensor]\npose = 0 0 1 0 0 0\n", "[sensor]\npose = 1\n", "[world]\nmax_corner = -20 0 0\n",
        "[world]\nmax_corner = 12 20 3\n", "[path]\nstep = 0\n", "[detector]\naccuracy = 1.5\n",
        "[world]\nlandmark = 3\n"}) {
    EXPECT_THROW(simulate(scenario_of(ini)), Error) << ini;
  }
}

TEST(RobotPath, ShapesStepAndClose) {
  for (const std::string shape : {"circle", "lawnmower", "waypoints"}) {
    const Scenario scenario = scenario_of(
        "[simulation]\ndimension = 3d\n[path]\nheight = 1\nroll_deg = 5\nmax_turn_deg = 10\n"
        "waypoints = 5 0 5 5 0 0\nshape = " +
        shape + "\n");
    const auto path = robot_path(scenario.path, true);
    EXPECT_GT(path.size(), 10U) << shape;
    EXPECT_NEAR(path.front().distanceTo(path.back()), 0, 1e-6) << shape;
    for (std::size_t i = 1; i < path.size(); ++i) {
      const auto motion = path[i] - path[i - 1];
      EXPECT_LT(std::hypot(motion.x(), motion.y()), 0.55) << shape << i;
      EXPECT_LT(std::abs(motion.yaw()), 11 * M_PI / 180) << shape << i;
      // The robot drives where it looks: neither sideways nor off its own plane by much.
      EXPECT_LT(std::hypot(motion.y(), motion.z()), 0.06) << shape << i;
    }
  }
}

TEST(Random, MomentsAndRange) {
  Random random(5);
  double sum = 0, square = 0, least = 1, most = 0;
  int events = 0;
  constexpr int kDraws = 100000;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.normal(2), u = random.uniform();
    sum += x;
    square += x * x;
    least = std::min(least, u);
    most = std::max(most, u);
    events += random.poisson(1.5);
  }
  EXPECT_NEAR(sum / kDraws, 0, 0.03);
  EXPECT_NEAR(square / kDraws, 4, 0.08);
  EXPECT_NEAR(static_cast<double>(events) / kDraws, 1.5, 0.02);
  EXPECT_GE(least, 0);
  EXPECT_LT(least, 1e-3);
  EXPECT_LT(most, 1);
  EXPECT_GT(most, 0.999);
}

TEST(Simulator, ARobotWhoseNameMakesNoFileNameIsRefused) {
  const std::string text = "[robot.../a]\n";
  IniFile ini(text, "team.ini");
  EXPECT_THROW(read_robots(ini, [&] { return std::make_unique<IniFile>(text, "team.ini"); }),
               Error);
}

TEST(Simulator, RobotsOfOneWorldSeeEachOther) {
  const std::string text =
      "[simulation]\nseed = 5\n[path]\nradius = 3\n[robot.a]\nid = -101\n"
      "[robot.b]\nid = -102\npath.start = 2 1 90\npath.period = 0.25\n";
  IniFile ini(text, "team.ini");
  const auto robots = read_robots(ini, [&] { return std::make_unique<IniFile>(text, "team.ini"); });
  read_scenario(ini);
  ini.reject_unknown();
  ASSERT_EQ(robots.size(), 2U);
  EXPECT_EQ(robots[1].name, "b");
  const Simulation a = simulate(robots[0].scenario), b = simulate(robots[1].scenario);
  ASSERT_EQ(a.landmarks.size(), b.landmarks.size());
  for (std::size_t i = 0; i < a.landmarks.size(); ++i) {
    EXPECT_EQ(a.landmarks[i].position, b.landmarks[i].position);
  }
  EXPECT_NEAR(b.path[0].x(), 2, 1e-12);
  EXPECT_NEAR(b.path[0].yaw(), M_PI / 2, 1e-12);
  std::size_t seen = 0;
  for (std::size_t i = 0; 2 * i < b.path.size() && i < a.path.size(); ++i) {
    for (const SimulatedDetection& d : a.frames[i].detections) {
      if (d.robot != -102) continue;
      ++seen;
      EXPECT_EQ(d.true_id, -1);
      EXPECT_NEAR(d.range, a.path[i].distanceTo(b.path[2 * i]), 5 * 0.05) << i;
    }
  }
  EXPECT_GE(seen, 3U);
}

}  // namespace
}  // namespace hybrid
