// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/log_writer.h"

#include <fmt/format.h>
#include <mrpt/core/Clock.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/serialization/CArchive.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/input/gzip_file.h"

namespace hybrid {
namespace {

constexpr int kCompression = 6;
constexpr const char* kPart = ".part";
constexpr const char* kPathSuffix = "_ground_truth_robot_path.txt";

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
  // With emOdometry, MRPT stores the raw reading and computes the distribution anew on reading.
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

}  // namespace

LogWriter::LogWriter(const std::string& path) : path_(path) {
  const std::filesystem::path log(path);
  if (log.extension() != ".rawlog") {
    throw Error(fmt::format("cannot write {}: the name of a log ends with .rawlog", path));
  }
  stem_ = (log.parent_path() / log.stem()).string();
  if (log.has_parent_path()) std::filesystem::create_directories(log.parent_path());
  std::string why;
  if (!file_.open(path_ + kPart, kCompression, why)) {
    throw Error(fmt::format("cannot write {}: {}", path, why));
  }
}

LogWriter::~LogWriter() {
  file_.close();
  std::error_code ignored;
  std::filesystem::remove(path_ + kPart, ignored);
  for (const auto& [suffix, file] : side_files_) {
    std::filesystem::remove(stem_ + suffix + kPart, ignored);
  }
}

std::ofstream& LogWriter::side_file(const std::string& suffix, const std::string& header) {
  const auto [it, is_new] = side_files_.try_emplace(suffix);
  if (is_new) {
    it->second.open(stem_ + suffix + kPart, std::ios::binary);
    it->second << header;
  }
  return it->second;
}

void LogWriter::add(const ImportedStep& step) {
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
  auto archive = mrpt::serialization::archiveFrom(file_);
  if (step.motion && report_.steps > 0) {
    archive << (step.motion->is_planar ? action_2d(*step.motion, stamp)
                                       : action_3d(*step.motion, stamp));
  }
  mrpt::obs::CSensoryFrame frame;
  for (const auto& observation : step.observations) {
    observation->timestamp = stamp;
    if (const auto* seen = dynamic_cast<CObservationClassedBearingRange*>(observation.get())) {
      report_.detections += seen->detections.size();
    }
    frame.insert(observation);
  }
  archive << frame;
  if (step.truth) {
    const auto& T = *step.truth;
    side_file(kPathSuffix, "% x y z yaw pitch roll\n")
        << fmt::format("{:.6f} {:.6f} {:.6f} {:.8f} {:.8f} {:.8f}\n", T.x(), T.y(), T.z(), T.yaw(),
                       T.pitch(), T.roll());
  }
  last_time_ = step.time;
  report_.observations += step.observations.size();
  ++report_.steps;
}

void LogWriter::true_landmark(std::int64_t id, const Eigen::Vector3d& position,
                              const std::string& class_name) {
  side_file("_ground_truth.txt", "% x y z 5 0 0 ID [class]\n")
      << fmt::format("{:.6f} {:.6f} {:.6f} 5 0 0 {}{}{}\n", position.x(), position.y(),
                     position.z(), id, class_name.empty() ? "" : " ", class_name);
  ++report_.landmarks;
}

void LogWriter::true_position(double time, const Eigen::Vector3d& position) {
  side_file("_ground_truth_robot_path.xyz", "% time x y z\n") << fmt::format(
      "{:.6f} {:.4f} {:.4f} {:.4f}\n", time, position.x(), position.y(), position.z());
}

void LogWriter::true_association(std::size_t index, std::int64_t true_id) {
  side_file("_ground_truth_associations.csv", "step,measurement,true_id\n")
      << fmt::format("{},{},{}\n", report_.steps, index, true_id);
}

ImportReport LogWriter::finish() {
  file_.close();
  if (check_gzip(path_ + kPart).state != GzipCheck::State::kSound) {
    throw Error(fmt::format("cannot write {}: it came out damaged; is the disk full?", path_));
  }
  for (auto& [suffix, file] : side_files_) {
    file.close();
    if (!file) throw Error(fmt::format("cannot write {}{}", stem_, suffix));
  }
  report_.files.push_back(path_);
  for (const auto& [suffix, file] : side_files_) report_.files.push_back(stem_ + suffix);
  for (const std::string& name : report_.files) std::filesystem::rename(name + kPart, name);
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
