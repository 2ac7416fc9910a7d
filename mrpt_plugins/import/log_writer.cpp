// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/log_writer.h"

#include <fmt/format.h>
#include <mrpt/core/Clock.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/serialization/CArchive.h>

#include <filesystem>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/folders.h"
#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/bridge/interrupt.h"

namespace hybrid {
namespace {

std::function<void(const ImportProgress&)> step_watcher;

constexpr int kCompression = 6;

mrpt::obs::CActionCollection action_2d(const OdometryIncrement& motion,
                                       mrpt::system::TTimeStamp stamp) {
  const mrpt::poses::CPose2D mean(motion.mean);
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(mean.phi()).toRotationMatrix();
  auto pdf = mrpt::poses::CPosePDFGaussian::Create();
  pdf->mean = mean;
  pdf->cov = mrpt::math::CMatrixDouble33(
      Eigen::Matrix3d(J * planar_part(motion.covariance) * J.transpose()));
  mrpt::obs::CActionRobotMovement2D action;
  action.timestamp = stamp;
  // With emOdometry, MRPT stores the raw reading and recomputes the distribution on loading.
  action.estimationMethod = mrpt::obs::CActionRobotMovement2D::emScan2DMatching;
  action.poseChange = pdf;
  return mrpt::obs::CActionCollection(action);
}

mrpt::obs::CActionCollection action_3d(const OdometryIncrement& motion,
                                       mrpt::system::TTimeStamp stamp) {
  mrpt::obs::CActionRobotMovement3D action;
  action.timestamp = stamp;
  action.rawOdometryIncrementReading = motion.mean;
  action.poseChange = pose_pdf(motion.mean, motion.covariance);
  return mrpt::obs::CActionCollection(action);
}

const std::string& checked(const std::string& path) {
  if (std::filesystem::path(path).extension() == ".rawlog") return path;
  throw Error(fmt::format("cannot write '{}': the name of a log ends with .rawlog", path));
}

}  // namespace

LogWriter::LogWriter(const std::string& path) : files_(checked(path), kCompression) {}

FileWriter& LogWriter::side_file(std::string_view suffix, const std::string& header) {
  const auto known = side_files_.find(suffix);
  if (known != side_files_.end()) return known->second;
  FileWriter& file =
      side_files_.try_emplace(suffix, files_.stage_beside(suffix), files_.path_beside(suffix))
          .first->second;
  file.write(header);
  return file;
}

void watch_steps(std::function<void(const ImportProgress&)> watcher) {
  step_watcher = std::move(watcher);
}

void LogWriter::add(const ImportedStep& step) {
  throw_if_interrupted();
  if (report_.steps == 0) {
    first_time_ = step.time;
    has_truth_ = step.truth.has_value();
  } else if (step.time < last_time_) {
    throw Error(fmt::format("step {} at {} s is before step {} at {} s", report_.steps, step.time,
                            report_.steps - 1, last_time_));
  }
  if (step.truth.has_value() != has_truth_) {
    throw Error(fmt::format("step {}: the true pose is known at some steps only", report_.steps));
  }
  const auto stamp = mrpt::Clock::fromDouble(step.time);
  auto archive = mrpt::serialization::archiveFrom<mrpt::io::CStream>(files_.log());
  if (step.motion && report_.steps > 0) {
    archive << (step.motion->is_planar ? action_2d(*step.motion, stamp)
                                       : action_3d(*step.motion, stamp));
  }
  mrpt::obs::CSensoryFrame frame;
  for (const auto& observation : step.observations) {
    observation->timestamp = stamp;
    if (const auto* seen = dynamic_cast<CObservationClassedBearingRange*>(observation.get())) {
      report_.detections += seen->detections.size();
    } else if (const auto* ranges =
                   dynamic_cast<mrpt::obs::CObservationBeaconRanges*>(observation.get())) {
      report_.detections += ranges->sensedData.size();
    }
    frame.insert(observation);
  }
  for (const auto& observation : step.stamped) frame.insert(observation);
  archive << frame;
  files_.log().check();
  if (step.truth) {
    const auto& T = *step.truth;
    side_file(kTruePathSuffix, "% x y z yaw pitch roll\n")
        .write(fmt::format("{:.6f} {:.6f} {:.6f} {:.8f} {:.8f} {:.8f}\n", T.x(), T.y(), T.z(),
                           T.yaw(), T.pitch(), T.roll()));
  }
  last_time_ = step.time;
  report_.observations += step.observations.size() + step.stamped.size();
  ++report_.steps;
  if (step_watcher) step_watcher({report_.steps, last_time_ - first_time_, share_});
}

void LogWriter::add_odometry(double time, const mrpt::poses::CPose3D& pose, bool is_3d) {
  auto archive = mrpt::serialization::archiveFrom<mrpt::io::CStream>(files_.log());
  const auto add = [&](auto reading) {
    reading.timestamp = mrpt::Clock::fromDouble(time);
    reading.sensorLabel = "ODOMETRY";
    archive << reading;
  };
  if (is_3d) {
    mrpt::obs::CObservationRobotPose reading;
    reading.pose.mean = pose;
    add(reading);
  } else {
    mrpt::obs::CObservationOdometry reading;
    reading.odometry = mrpt::poses::CPose2D(pose);
    add(reading);
  }
  files_.log().check();
}

void LogWriter::true_landmark(std::int64_t id, const Eigen::Vector3d& position,
                              const std::string& class_name) {
  side_file(kTrueMapSuffix, "% x y z 5 0 0 ID [class]\n")
      .write(fmt::format("{:.6f} {:.6f} {:.6f} 5 0 0 {}{}{}\n", position.x(), position.y(),
                         position.z(), id, class_name.empty() ? "" : " ", class_name));
  ++report_.landmarks;
}

void LogWriter::true_position(double time, const Eigen::Vector3d& position) {
  write_position(kTruePositionsSuffix, time, position);
}

void LogWriter::held_out_fix(double time, const Eigen::Vector3d& position) {
  write_position(kHeldOutFixesSuffix, time, position);
}

void LogWriter::write_position(std::string_view suffix, double time,
                               const Eigen::Vector3d& position) {
  side_file(suffix, "% time x y z\n")
      .write(fmt::format("{:.6f} {:.4f} {:.4f} {:.4f}\n", time, position.x(), position.y(),
                         position.z()));
}

void LogWriter::true_association(std::size_t index, std::int64_t true_id) {
  side_file(kTrueAssociationsSuffix, "step,measurement,true_id\n")
      .write(fmt::format("{},{},{}\n", report_.steps, index, true_id));
}

void LogWriter::true_mover(std::int64_t true_id, const Eigen::Vector3d& position) {
  side_file(kTrueMoversSuffix, "step,id,x,y,z\n")
      .write(fmt::format("{},{},{:.6f},{:.6f},{:.6f}\n", report_.steps, true_id, position.x(),
                         position.y(), position.z()));
}

void LogWriter::name_of(std::int64_t id, const std::string& name) {
  side_file(kIdNamesSuffix, "id,name\n").write(fmt::format("{},{}\n", id, name));
}

void LogWriter::note_end(const std::string& input) {
  if (std::filesystem::is_directory(input)) {
    note_ends(input);
  } else if (ends_in_line(input)) {
    note(input + ": its last line has no end; is the file cut off?");
  }
}

void LogWriter::note_ends(const std::string& folder) {
  std::size_t count = 0;
  std::vector<std::string> without;
  for (const FolderEntry& entry : entries_of(folder)) {
    if (std::filesystem::path(entry.name).extension() != ".txt") continue;
    ++count;
    if (ends_in_line(folder + "/" + entry.name)) without.push_back(entry.name);
  }
  if (without.empty() || without.size() == count) return;
  note(
      fmt::format("{}: the last line of {} of {} files has no end, such as that of {}; are they "
                  "cut off?",
                  folder, without.size(), count, without.front()));
}

ImportReport LogWriter::finish() {
  for (auto& [suffix, file] : side_files_) file.close();
  report_.files = files_.commit();
  report_.duration = last_time_ - first_time_;
  return std::move(report_);
}

CObservationClassedBearingRange::Ptr planar_detections(const std::string& label,
                                                       const DetectorNoise& noise,
                                                       const mrpt::poses::CPose3D& T_robot_sensor) {
  auto frame = CObservationClassedBearingRange::Create();
  frame->sensorLabel = label;
  frame->sensor_pose = T_robot_sensor;
  frame->has_pitch = false;
  frame->std_range = static_cast<float>(noise.range);
  frame->std_yaw = static_cast<float>(noise.bearing);
  return frame;
}

OdometryIncrement planar_motion(double x, double y, double angle,
                                const Eigen::Matrix3d& covariance) {
  return {mrpt::poses::CPose3D(x, y, 0, angle, 0, 0), planar_to_6d(covariance), true};
}

}  // namespace hybrid
