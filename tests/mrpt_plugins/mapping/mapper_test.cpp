// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/mapper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

/// A world of classed landmarks around a robot that drives a circle of 5 m, and what it senses.
struct World {
  bool is_3d = false;
  CPose3D T_robot_sensor;
  double noise = 1.0;  ///< in sigmas
  std::mt19937 random{1};
  std::vector<Eigen::Vector3d> landmarks;

  explicit World(bool in_space) : is_3d(in_space), T_robot_sensor(0.3, -0.2, 0, 0.5, 0, 0) {
    if (is_3d) T_robot_sensor = CPose3D(0.3, -0.2, 0.4, 0.5, 0.2, -0.1);
    for (int i = 0; i < 8; ++i) {
      landmarks.emplace_back(7 * std::cos(i), 5 + 7 * std::sin(i), is_3d ? 0.5 * i - 2 : 0.0);
    }
  }

  double gauss(double sigma) { return noise * sigma * std::normal_distribution<double>()(random); }

  CPose3D true_pose(int i) const {
    const double a = 0.2 * i;
    const double z = is_3d ? 0.3 * std::sin(a) : 0.0;
    return {5 * std::sin(a), 5 - 5 * std::cos(a), z, a, is_3d ? 0.1 * std::sin(2 * a) : 0.0, 0};
  }

  Keyframe keyframe(int i) {
    Keyframe out;
    out.row = static_cast<std::size_t>(i);
    out.time = i;
    if (i > 0) {
      OdometryIncrement odometry;
      const CPose3D step = true_pose(i) - true_pose(i - 1);
      odometry.mean = step + CPose3D(gauss(0.05), gauss(0.05), 0, gauss(0.02), 0, 0);
      odometry.is_planar = !is_3d;
      odometry.covariance.diagonal() << 25e-4, 25e-4, 1e-4, 1e-4, 1e-4, 4e-4;
      out.odometry = odometry;
    }
    DetectionFrame frame;
    frame.is_3d = is_3d;
    frame.T_robot_sensor = to_isometry(T_robot_sensor);
    frame.class_names = {"tree", "car"};
    for (std::size_t id = 0; id < landmarks.size(); ++id) {
      Detection d;
      const CPose3D T_map_sensor = true_pose(i) + T_robot_sensor;
      T_map_sensor.sphericalCoordinates({landmarks[id].x(), landmarks[id].y(), landmarks[id].z()},
                                        d.range, d.yaw, d.pitch);
      d.range += gauss(0.02);
      d.yaw += gauss(0.01);
      d.pitch = is_3d ? d.pitch + gauss(0.01) : 0.0;
      d.id = static_cast<std::int64_t>(id);
      const bool right = std::uniform_real_distribution<double>()(random) < 0.75;
      const bool tree = (id % 2 == 0) == right;
      d.class_probabilities = {tree ? 0.75 : 0.25, tree ? 0.25 : 0.75};
      d.covariance.diagonal() << 4e-4, 1e-4, is_3d ? 1e-4 : 0.0;
      frame.detections.push_back(d);
    }
    out.detections = {frame};
    return out;
  }
};

Mapper make_mapper(const std::string& plugin, bool is_3d, IniFile& ini) {
  return {read_motion_options(ini),
          {make_plugin(plugin, ini)},
          make_backend(ini.section("solver")),
          is_3d};
}

struct Case {
  bool is_3d;
  const char* mode;
};

class Mapping : public ::testing::TestWithParam<Case> {
 protected:
  const bool is_3d_ = GetParam().is_3d;
  IniFile ini_{std::string("[solver]\nmode = ") + GetParam().mode + "\n", "test.ini"};
};

TEST_P(Mapping, PerfectMeasurementsGiveThePerfectMap) {
  World world(is_3d_);
  world.noise = 0;
  Mapper mapper = make_mapper("BearingRangeKnownIds", is_3d_, ini_);
  for (int i = 0; i < 20; ++i) mapper.add(world.keyframe(i));
  EXPECT_NEAR(mapper.finish().cost, 0.0, 1e-9);
  const MapResult result = mapper.result();
  ASSERT_EQ(result.landmarks.size(), world.landmarks.size());
  for (const LandmarkEstimate& landmark : result.landmarks) {
    EXPECT_LT((landmark.position - world.landmarks[landmark.id]).norm(), 1e-6);
    EXPECT_EQ(landmark.sightings, 20);
    EXPECT_FALSE(landmark.class_index);
    EXPECT_GT(landmark.covariance(0, 0), 0.0);
  }
  for (int i = 0; i < 20; ++i) {
    EXPECT_LT((result.trajectory[i].pose - world.true_pose(i)).norm(), 1e-6);
  }
}

TEST(MapperWork, IsCountedAndLimited) {
  IniFile ini("", "test.ini");
  Mapper counted = make_mapper("BearingRangeKnownIds", false, ini);
  Mapper same = make_mapper("BearingRangeKnownIds", false, ini);
  Mapper limited = make_mapper("BearingRangeKnownIds", false, ini);
  World world(false);
  for (int i = 0; i < 20; ++i) {
    const Keyframe keyframe = world.keyframe(i);
    counted.add(keyframe);
    same.add(keyframe);
  }
  EXPECT_GT(counted.work(), 20);
  limited.limit_work(counted.work() / 2);
  counted.finish();
  same.finish();
  EXPECT_EQ(counted.work(), same.work());
  World again(false);
  EXPECT_THROW(
      {
        for (int i = 0; i < 20; ++i) limited.add(again.keyframe(i));
        limited.finish();
      },
      TooMuchWork);
  EXPECT_LT(limited.work(), counted.work());
}

TEST_P(Mapping, NoisyMeasurementsGiveMapClassesAndAMonotoneObjective) {
  World world(is_3d_);
  Mapper mapper = make_mapper("ClassedBearingRangeKnownIds", is_3d_, ini_);
  StepRecord last;
  for (int i = 0; i < 40; ++i) last = *mapper.add(world.keyframe(i));
  const Estimate before{mapper.backend().values(), mapper.backend().assignment()};
  EXPECT_NEAR(last.objective_after,
              objective(mapper.backend().graph(), before.values, before.assignment),
              1e-6 * std::abs(last.objective_after));
  EXPECT_NEAR(last.cost, cost(mapper.backend().graph(), before.values, before.assignment),
              1e-6 * last.cost);
  const BackendReport report = mapper.finish();
  // Short windows are solved to the end with each keyframe.
  const bool is_short = std::string(GetParam().mode) == "filter" ||
                        std::string(GetParam().mode).rfind("fixed_lag", 0) == 0;
  ASSERT_GE(report.objectives.size(), is_short ? 1U : 2U);
  for (std::size_t k = 1; k < report.objectives.size(); ++k) {
    EXPECT_LE(report.objectives[k], report.objectives[k - 1]) << "half-step " << k;
  }
  EXPECT_LE(report.objective_after, last.objective_after);
  const MapResult result = mapper.result();
  EXPECT_EQ(result.class_names, std::vector<std::string>({"tree", "car"}));
  for (const LandmarkEstimate& landmark : result.landmarks) {
    EXPECT_LT((landmark.position - world.landmarks[landmark.id]).norm(), 0.1);
    EXPECT_EQ(landmark.class_index, static_cast<int>(landmark.id % 2));
    ASSERT_EQ(landmark.class_probabilities.size(), 2U);
    EXPECT_NEAR(landmark.class_probabilities[0] + landmark.class_probabilities[1], 1.0, 1e-9);
    EXPECT_GT(landmark.class_probabilities[landmark.id % 2], 0.9);
  }
  const auto covariances = mapper.pose_covariances();
  ASSERT_EQ(covariances.size(), 40U);
  EXPECT_EQ(covariances[39].rows(), is_3d_ ? 6 : 3);
}

INSTANTIATE_TEST_SUITE_P(DimensionsAndModes, Mapping,
                         ::testing::Values(Case{false, "batch"}, Case{true, "batch"},
                                           Case{false, "incremental"}, Case{true, "incremental"},
                                           Case{false, "bounded"}, Case{true, "bounded"},
                                           Case{false, "fixed_lag\nlag = 5"},
                                           Case{true, "fixed_lag\nlag = 5"}, Case{false, "filter"},
                                           Case{true, "filter"}));

TEST(Mapper, AllWaysToSolveEndAtTheSameEstimate) {
  std::vector<double> objectives;
  for (const char* text :
       {"[solver]\nmode = batch\n", "[solver]\nmode = batch\nsolve_every = 5\n",
        "[solver]\nmode = incremental\n", "", "[solver]\nmode = fixed_lag\nlag = 0\n",
        "[solver]\nmode = incremental\nstep = dogleg\n"}) {
    World world(false);
    IniFile ini(text, "test.ini");
    Mapper mapper = make_mapper("ClassedBearingRangeKnownIds", false, ini);
    for (int i = 0; i < 20; ++i) mapper.add(world.keyframe(i));
    objectives.push_back(mapper.finish().objective_after);
  }
  for (const double objective : objectives) EXPECT_NEAR(objective, objectives[0], 1e-4);
}

TEST(Mapper, MissingOdometryIsBridgedAndCounted) {
  World world(false);
  world.noise = 0;
  IniFile ini("", "test.ini");
  Mapper mapper = make_mapper("BearingRangeKnownIds", false, ini);
  for (int i = 0; i < 10; ++i) {
    Keyframe keyframe = world.keyframe(i);
    if (i == 5) keyframe.odometry.reset();
    mapper.add(keyframe);
  }
  mapper.finish();
  EXPECT_EQ(mapper.dropped().at("odometry missing: robot taken to stand still"), 1U);
  EXPECT_LT((mapper.result().trajectory[9].pose - world.true_pose(9)).norm(), 0.01);
}

TEST(Mapper, StandingStillIsBelieved) {
  MotionOptions options;
  options.standstill_sigma_m = 1e-4;
  options.standstill_sigma_rad = 1e-5;
  OdometryIncrement odometry;
  odometry.covariance.diagonal().setConstant(1e-2);
  Values values;
  values.insert(Key('x', 0), SE2());
  values.insert(Key('x', 1), SE2(1e-3, 0, 0));
  const auto still = odometry_factor(Key('x', 0), Key('x', 1), odometry, options, false);
  EXPECT_NEAR(still->cost(values), 0.5 * 100, 1e-6);
  odometry.mean = CPose3D(1e-3, 0, 0, 0, 0, 0);
  const auto moving = odometry_factor(Key('x', 0), Key('x', 1), odometry, options, false);
  values.update(Key('x', 1), SE2(0.1 + 1e-3, 0, 0));
  EXPECT_NEAR(moving->cost(values), 0.5 * 1, 1e-6);
}

TEST(Mapper, DetectionsThatDoNotFitTheMapAreDropped) {
  World world(true);
  IniFile ini("", "test.ini");
  Mapper mapper = make_mapper("BearingRangeKnownIds", false, ini);
  mapper.add(world.keyframe(0));
  EXPECT_EQ(mapper.landmarks().size(), 0U);
  EXPECT_EQ(mapper.dropped().at("detection dropped: pitch measured, but the map is in the plane"),
            world.landmarks.size());
}

TEST(Mapper, WhatCannotBeUsedIsCountedAndToldWithItsFrame) {
  World world(false);
  IniFile ini("", "test.ini");
  Mapper mapper = make_mapper("ClassedBearingRangeKnownIds", false, ini);
  Keyframe keyframe = world.keyframe(0);
  keyframe.row = 17;
  keyframe.detections[0].class_names.clear();
  for (Detection& d : keyframe.detections[0].detections) d.class_probabilities.clear();
  mapper.add(keyframe);
  EXPECT_EQ(mapper.landmarks().size(), 0U);
  EXPECT_EQ(mapper.dropped().at("observations dropped: not usable"), 1U);
  ASSERT_EQ(mapper.warnings().size(), 1U);
  EXPECT_NE(mapper.warnings()[0].find("step 17"), std::string::npos) << mapper.warnings()[0];
  EXPECT_NE(mapper.warnings()[0].find("class_names"), std::string::npos) << mapper.warnings()[0];
  mapper.add(world.keyframe(1));
  EXPECT_EQ(mapper.landmarks().size(), world.landmarks.size());
}

TEST(Plugins, UnknownClassListsTheRegisteredOnes) {
  IniFile ini("", "test.ini");
  try {
    make_plugin("BearingRange", ini);
    FAIL() << "an unknown class was made";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("BearingRangeKnownIds, ClassedBearingRangeKnownIds"),
              std::string::npos)
        << e.what();
  }
  EXPECT_NE(make_plugin("hybrid::BearingRangeKnownIds", ini), nullptr);
}

}  // namespace
}  // namespace hybrid
