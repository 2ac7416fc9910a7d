// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>
#include <mrpt/core/Clock.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include <cmath>

#include "libhybrid/io/file_writer.h"
#include "mrpt_plugins/bridge/log_files.h"
#include "mrpt_plugins/bridge/satellite_fix.h"
#include "mrpt_plugins/observations/classed_bearing_range.h"
#include "mrpt_plugins/output/fix_writer.h"
#include "mrpt_plugins/simulation/simulator.h"

namespace hybrid {
namespace {

/// 2026-01-01 00:00 UTC: fixed, so that results are reproducible byte by byte.
constexpr double kStartTime = 1767225600.0;
constexpr const char* kSensorLabel = "DETECTOR";
constexpr int kCompression = 9;

mrpt::system::TTimeStamp stamp(const Scenario& scenario, std::size_t frame) {
  return mrpt::Clock::fromDouble(kStartTime + static_cast<double>(frame) * scenario.path.period);
}

std::int32_t reported_id(const SimulatedDetection& d, const Scenario& scenario) {
  if (!scenario.sensor.known_ids || d.moves) return mrpt::obs::INVALID_LANDMARK_ID;
  return d.robot != mrpt::obs::INVALID_LANDMARK_ID ? d.robot : static_cast<std::int32_t>(d.true_id);
}

mrpt::obs::CObservation::Ptr classed_observation(const SimulatedFrame& frame,
                                                 const Scenario& scenario) {
  const auto& s = scenario.sensor;
  auto o = std::make_shared<CObservationClassedBearingRange>();
  o->sensor_pose = s.pose;
  o->min_range = static_cast<float>(s.min_range);
  o->max_range = static_cast<float>(s.max_range);
  o->fov_yaw = static_cast<float>(s.fov_yaw);
  o->fov_pitch = static_cast<float>(scenario.is_3d ? s.fov_pitch : 0);
  o->std_range = static_cast<float>(s.sigma_range);
  o->std_yaw = static_cast<float>(s.sigma_yaw);
  o->std_pitch = static_cast<float>(scenario.is_3d ? s.sigma_pitch : 0);
  o->has_pitch = scenario.is_3d;
  o->class_names = scenario.world.classes;
  for (const SimulatedDetection& d : frame.detections) {
    o->detections.push_back(
        {static_cast<float>(d.range), static_cast<float>(d.yaw), static_cast<float>(d.pitch),
         reported_id(d, scenario),
         s.true_ids ? static_cast<std::int32_t>(d.true_id) : mrpt::obs::INVALID_LANDMARK_ID,
         class_scores(s.confusion, d.reported_class)});
  }
  return o;
}

mrpt::obs::CObservation::Ptr plain_observation(const SimulatedFrame& frame,
                                               const Scenario& scenario) {
  const auto& s = scenario.sensor;
  auto o = mrpt::obs::CObservationBearingRange::Create();
  o->sensorLocationOnRobot = s.pose;
  o->minSensorDistance = static_cast<float>(s.min_range);
  o->maxSensorDistance = static_cast<float>(s.max_range);
  o->fieldOfView_yaw = static_cast<float>(s.fov_yaw);
  o->fieldOfView_pitch = static_cast<float>(scenario.is_3d ? s.fov_pitch : 0);
  o->sensor_std_range = static_cast<float>(s.sigma_range);
  o->sensor_std_yaw = static_cast<float>(s.sigma_yaw);
  o->sensor_std_pitch = static_cast<float>(scenario.is_3d ? s.sigma_pitch : 0);
  for (const SimulatedDetection& d : frame.detections) {
    o->sensedData.push_back({static_cast<float>(d.range),
                             static_cast<float>(d.yaw),
                             static_cast<float>(d.pitch),
                             reported_id(d, scenario),
                             {}});
  }
  return o;
}

mrpt::obs::CObservation::Ptr scan_observation(const SimulatedFrame& frame,
                                              const Scenario& scenario) {
  auto o = mrpt::obs::CObservation2DRangeScan::Create();
  o->sensorPose = scenario.laser.pose;
  o->aperture = static_cast<float>(scenario.laser.fov);
  o->maxRange = static_cast<float>(scenario.laser.max_range);
  o->stdError = static_cast<float>(scenario.laser.sigma_range);
  o->resizeScan(frame.scan.size());
  for (std::size_t i = 0; i < frame.scan.size(); ++i) {
    o->setScanRange(i, frame.scan[i]);
    o->setScanRangeValidity(i, frame.scan[i] > 0);
  }
  return o;
}

/// What the robot senses at a frame.
std::vector<mrpt::obs::CObservation::Ptr> observations(const SimulatedFrame& frame,
                                                       const Scenario& scenario,
                                                       mrpt::system::TTimeStamp time) {
  std::vector<mrpt::obs::CObservation::Ptr> all;
  if (scenario.has_detector()) {
    all.push_back(scenario.classed ? classed_observation(frame, scenario)
                                   : plain_observation(frame, scenario));
    all.back()->sensorLabel = kSensorLabel;
  }
  if (scenario.laser.rays > 0) {
    all.push_back(scan_observation(frame, scenario));
    all.back()->sensorLabel = "LASER";
  }
  for (const auto& observation : all) observation->timestamp = time;
  return all;
}

mrpt::obs::CActionCollection motion_2d(const SimulatedFrame& frame, const Scenario& scenario,
                                       mrpt::system::TTimeStamp time) {
  mrpt::obs::CActionRobotMovement2D action;
  action.timestamp = time;
  mrpt::obs::CActionRobotMovement2D::TMotionModelOptions options;
  options.modelSelection = mrpt::obs::CActionRobotMovement2D::mmGaussian;
  options.gaussianModel = {
      0, 0, 0, 0, scenario.odometry.sigma_translation, scenario.odometry.sigma_yaw};
  action.computeFromOdometry({frame.motion[0], frame.motion[1], frame.motion[3]}, options);
  return mrpt::obs::CActionCollection(action);
}

mrpt::obs::CActionCollection motion_3d(const SimulatedFrame& frame, const Scenario& scenario,
                                       mrpt::system::TTimeStamp time) {
  const auto& m = frame.motion;
  const auto& o = scenario.odometry;
  mrpt::obs::CActionRobotMovement3D action;
  action.timestamp = time;
  action.rawOdometryIncrementReading = {m[0], m[1], m[2], m[3], m[4], m[5]};
  action.poseChange.mean = action.rawOdometryIncrementReading;
  action.poseChange.cov.setZero();
  for (int i = 0; i < 3; ++i)
    action.poseChange.cov(i, i) = o.sigma_translation * o.sigma_translation;
  action.poseChange.cov(3, 3) = o.sigma_yaw * o.sigma_yaw;
  for (int i = 4; i < 6; ++i) action.poseChange.cov(i, i) = o.sigma_tilt * o.sigma_tilt;
  return mrpt::obs::CActionCollection(action);
}

mrpt::obs::CObservation::Ptr fix_observation(const SimulatedFix& fix, const Scenario& scenario) {
  const Scenario::Fixes& f = scenario.fixes;
  return satellite_fix({kStartTime + fix.time, fix.place,
                        static_cast<std::uint8_t>(f.stated_quality), f.stated_sigma},
                       "GPS", {f.antenna[0], f.antenna[1], f.antenna[2], 0, 0, 0});
}

void write_log(GzipWriter& file, const Simulation& simulation, const Scenario& scenario) {
  auto archive = mrpt::serialization::archiveFrom<mrpt::io::CStream>(file);
  mrpt::poses::CPose2D odometry;
  auto fix = simulation.fixes.begin();
  for (std::size_t i = 0; i < simulation.frames.size(); ++i) {
    const SimulatedFrame& frame = simulation.frames[i];
    const auto time = stamp(scenario, i);
    auto sensed = observations(frame, scenario, time);
    for (; fix != simulation.fixes.end() && fix->frame == i; ++fix) {
      sensed.push_back(fix_observation(*fix, scenario));
    }
    file.check();
    if (scenario.pairs) {
      if (i > 0) {
        archive << (scenario.is_3d ? motion_3d(frame, scenario, time)
                                   : motion_2d(frame, scenario, time));
      }
      mrpt::obs::CSensoryFrame sensory_frame;
      for (const auto& observation : sensed) sensory_frame.insert(observation);
      archive << sensory_frame;
    } else {
      odometry = odometry + mrpt::poses::CPose2D(frame.motion[0], frame.motion[1], frame.motion[3]);
      mrpt::obs::CObservationOdometry absolute;
      absolute.timestamp = time;
      absolute.sensorLabel = "ODOMETRY";
      absolute.odometry = odometry;
      archive << absolute;
      for (const auto& observation : sensed) archive << *observation;
    }
  }
}

void write_text(const LogFiles& files, std::string_view suffix, const std::string& text) {
  FileWriter file(files.stage_beside(suffix), files.path_beside(suffix));
  file.write(text);
  file.close();
}

std::string landmark_table(const Simulation& simulation, const Scenario& scenario) {
  std::string text = fmt::format("% classes: {}\n% x y z 5 0 0 ID class\n",
                                 fmt::join(scenario.world.classes, " "));
  for (const SimulatedLandmark& l : simulation.landmarks) {
    text += fmt::format("{:.9f} {:.9f} {:.9f} 5 0 0 {} {}\n", l.position[0], l.position[1],
                        l.position[2], l.id, l.class_index);
  }
  return text;
}

std::string path_table(const Simulation& simulation) {
  std::string text = "% x y z yaw pitch roll\n";
  for (const auto& T : simulation.path) {
    text += fmt::format("{:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", T.x(), T.y(), T.z(), T.yaw(),
                        T.pitch(), T.roll());
  }
  return text;
}

std::string mover_table(const Simulation& simulation) {
  std::string text = "step,id,x,y,z\n";
  for (const SimulatedMover& mover : simulation.movers) {
    for (std::size_t i = 0; i < mover.path.size(); ++i) {
      const auto& p = mover.path[i];
      text += fmt::format("{},{},{:.9f},{:.9f},{:.9f}\n", i, mover.id, p[0], p[1], p[2]);
    }
  }
  return text;
}

std::string mode_table(const Simulation& simulation) {
  std::string text = "% 0 normal, 1 slip: how each frame was reached\n";
  for (const SimulatedFrame& frame : simulation.frames) text += frame.slips ? "1\n" : "0\n";
  return text;
}

std::string fix_table(const Simulation& simulation) {
  std::string text = "time,mode,error_east,error_north,error_up\n";
  for (const SimulatedFix& fix : simulation.fixes) {
    const auto& e = fix.error;
    text += fmt::format("{:.6f},{},{:.6f},{:.6f},{:.6f}\n", kStartTime + fix.time,
                        to_string(fix.mode), e.x(), e.y(), e.z());
  }
  return text;
}

}  // namespace

std::vector<std::string> write_simulation(const Simulation& simulation, const Scenario& scenario,
                                          const std::string& log_path) {
  LogFiles files(log_path, kCompression);
  write_log(files.log(), simulation, scenario);
  write_text(files, kTrueMapSuffix, landmark_table(simulation, scenario));
  write_text(files, kTruePathSuffix, path_table(simulation));
  if (scenario.slip.start > 0) write_text(files, kTrueModesSuffix, mode_table(simulation));
  if (!simulation.movers.empty()) write_text(files, kTrueMoversSuffix, mover_table(simulation));
  if (scenario.fixes.period > 0) write_text(files, kTrueFixesSuffix, fix_table(simulation));
  return files.commit();
}

}  // namespace hybrid
