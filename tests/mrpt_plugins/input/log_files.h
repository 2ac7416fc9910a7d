// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/serialization/CArchive.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace hybrid {

using Objects = std::vector<mrpt::serialization::CSerializable::Ptr>;

/// A path in the system's temporary folder, removed with whatever stands there at the end.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& name)
      : path_((std::filesystem::temp_directory_path() /
               ("hybrid_" + std::to_string(getpid()) + "_" + name))
                  .string()) {}
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

inline void write_log(const std::string& path, const Objects& objects) {
  mrpt::io::CFileGZOutputStream file(path);
  auto archive = mrpt::serialization::archiveFrom(file);
  for (const auto& object : objects) archive << *object;
}

inline std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

inline void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

inline mrpt::obs::CObservation::Ptr observation(double time) {
  auto o = mrpt::obs::CObservationBearingRange::Create();
  o->timestamp = mrpt::Clock::fromDouble(time);
  o->sensor_std_range = 0.1F;
  o->sensor_std_yaw = 0.01F;
  o->sensedData.push_back({2.0F, 0.5F, 0.0F, 3, {}});
  return o;
}

inline mrpt::obs::CObservation::Ptr absolute_odometry(double time,
                                                      const mrpt::poses::CPose2D& pose) {
  auto o = mrpt::obs::CObservationOdometry::Create();
  o->timestamp = mrpt::Clock::fromDouble(time);
  o->odometry = pose;
  return o;
}

inline mrpt::serialization::CSerializable::Ptr frame(
    const std::vector<mrpt::obs::CObservation::Ptr>& observations) {
  auto f = mrpt::obs::CSensoryFrame::Create();
  for (const auto& o : observations) f->insert(o);
  return f;
}

inline mrpt::serialization::CSerializable::Ptr motion_2d(const mrpt::poses::CPose2D& motion,
                                                         double sigma) {
  mrpt::obs::CActionRobotMovement2D action;
  action.timestamp = INVALID_TIMESTAMP;
  // With emOdometry, MRPT stores the raw reading and computes the distribution anew on reading.
  action.estimationMethod = mrpt::obs::CActionRobotMovement2D::emScan2DMatching;
  mrpt::poses::CPosePDFGaussian pdf(motion);
  pdf.cov.setDiagonal(3, sigma * sigma);
  action.poseChange =
      mrpt::poses::CPosePDF::Ptr(std::make_shared<mrpt::poses::CPosePDFGaussian>(pdf));
  return std::make_shared<mrpt::obs::CActionCollection>(action);
}

}  // namespace hybrid
