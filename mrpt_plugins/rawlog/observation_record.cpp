// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/observation_record.h"

#include <fmt/format.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/serialization/CArchive.h>

#include <memory>

#include "mrpt_plugins/observations/classed_bearing_range.h"
#include "mrpt_plugins/rawlog/detail/cloud_record.h"
#include "mrpt_plugins/rawlog/detail/fix_record.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservation;
using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservationBeaconRanges;
using mrpt::obs::CObservationBearingRange;
using mrpt::obs::CObservationGPS;
using mrpt::obs::CObservationOdometry;
using mrpt::obs::CObservationRobotPose;
using Classed = CObservationClassedBearingRange;

constexpr const char* kCloudClass = "mrpt::obs::CObservationPointCloud";

enum class Form : std::uint8_t {
  kAbsent,
  kMrpt,
  kOdometry,
  kBearingRange,
  kClassed,
  kBeacons,
  kScan,
  kRobotPose,
  kFix,
  kCloud
};

void put_count(ByteWriter& out, std::size_t count, const char* what) {
  if (count > kMaxDetections) {
    throw Error(fmt::format("{} {} in one observation", count, what));
  }
  out.put(static_cast<std::uint32_t>(count));
}

void write(ByteWriter& out, const CObservationOdometry& o) {
  write_pose(out, o.odometry);
}

void read(ByteReader& in, CObservationOdometry& o) {
  o.odometry = read_pose_2d(in);
}

void write(ByteWriter& out, const CObservationRobotPose& o) {
  write_pose(out, o.pose.mean);
}

void read(ByteReader& in, CObservationRobotPose& o) {
  o.pose.mean = read_pose_3d(in);
}

void write(ByteWriter& out, const CObservationBearingRange& o) {
  put_all(out, o.minSensorDistance, o.maxSensorDistance, o.fieldOfView_yaw, o.fieldOfView_pitch,
          o.sensor_std_range, o.sensor_std_yaw, o.sensor_std_pitch);
  out.put_flag(o.validCovariances);
  write_pose(out, o.sensorLocationOnRobot);
  put_count(out, o.sensedData.size(), "detections");
  for (const auto& m : o.sensedData) {
    put_all(out, m.range, m.yaw, m.pitch, m.landmarkID);
    if (o.validCovariances) write_matrix(out, m.covariance);
  }
}

void read(ByteReader& in, CObservationBearingRange& o) {
  get_all(in, o.minSensorDistance, o.maxSensorDistance, o.fieldOfView_yaw, o.fieldOfView_pitch,
          o.sensor_std_range, o.sensor_std_yaw, o.sensor_std_pitch);
  o.validCovariances = in.flag();
  o.sensorLocationOnRobot = read_pose_3d(in);
  constexpr std::size_t kLeastBytes = 16;
  o.sensedData.resize(in.count(kLeastBytes));
  for (auto& m : o.sensedData) {
    get_all(in, m.range, m.yaw, m.pitch, m.landmarkID);
    if (o.validCovariances) read_matrix(in, m.covariance);
  }
}

void write(ByteWriter& out, const Classed& o) {
  write_pose(out, o.sensor_pose);
  put_all(out, o.min_range, o.max_range, o.fov_yaw, o.fov_pitch, o.std_range, o.std_yaw,
          o.std_pitch);
  out.put_flag(o.has_range);
  out.put_flag(o.has_pitch);
  put_count(out, o.class_names.size(), "classes");
  for (const std::string& name : o.class_names) out.put_text(name);
  put_count(out, o.detections.size(), "detections");
  for (const Classed::Detection& d : o.detections) {
    put_all(out, d.range, d.yaw, d.pitch, d.landmark_id, d.true_landmark_id, d.std_range, d.std_yaw,
            d.std_pitch);
    put_count(out, d.class_scores.size(), "class scores");
    for (const float score : d.class_scores) out.put(score);
  }
}

void read(ByteReader& in, Classed& o) {
  o.sensor_pose = read_pose_3d(in);
  get_all(in, o.min_range, o.max_range, o.fov_yaw, o.fov_pitch, o.std_range, o.std_yaw,
          o.std_pitch);
  o.has_range = in.flag();
  o.has_pitch = in.flag();
  o.class_names.resize(in.count(sizeof(std::uint32_t)));
  for (std::string& name : o.class_names) name = in.text();
  constexpr std::size_t kLeastBytes = 36;
  o.detections.resize(in.count(kLeastBytes));
  for (Classed::Detection& d : o.detections) {
    get_all(in, d.range, d.yaw, d.pitch, d.landmark_id, d.true_landmark_id, d.std_range, d.std_yaw,
            d.std_pitch);
    d.class_scores.resize(in.count(sizeof(float)));
    for (float& score : d.class_scores) score = in.get<float>();
  }
}

void write(ByteWriter& out, const CObservationBeaconRanges& o) {
  put_all(out, o.minSensorDistance, o.maxSensorDistance, o.stdError);
  write_pose(out, o.auxEstimatePose);
  put_count(out, o.sensedData.size(), "ranges");
  for (const auto& m : o.sensedData) {
    const auto& p = m.sensorLocationOnRobot;
    put_all(out, p.x(), p.y(), p.z(), m.sensedDistance, m.beaconID);
  }
}

void read(ByteReader& in, CObservationBeaconRanges& o) {
  get_all(in, o.minSensorDistance, o.maxSensorDistance, o.stdError);
  o.auxEstimatePose = read_pose_2d(in);
  constexpr std::size_t kLeastBytes = 32;
  o.sensedData.resize(in.count(kLeastBytes));
  for (auto& m : o.sensedData) {
    double x = 0, y = 0, z = 0;
    get_all(in, x, y, z, m.sensedDistance, m.beaconID);
    m.sensorLocationOnRobot = {x, y, z};
  }
}

void write(ByteWriter& out, const CObservation2DRangeScan& o) {
  put_all(out, o.aperture, o.maxRange, o.stdError, o.beamAperture, o.deltaPitch);
  out.put_flag(o.rightToLeft);
  write_pose(out, o.sensorPose);
  put_count(out, o.getScanSize(), "rays");
  for (std::size_t i = 0; i < o.getScanSize(); ++i) {
    out.put(o.getScanRange(i));
    out.put_flag(o.getScanRangeValidity(i));
  }
}

/// Without intensities, which nobody uses.
void read(ByteReader& in, CObservation2DRangeScan& o) {
  get_all(in, o.aperture, o.maxRange, o.stdError, o.beamAperture, o.deltaPitch);
  o.rightToLeft = in.flag();
  o.sensorPose = read_pose_3d(in);
  constexpr std::size_t kBytes = 5;
  o.resizeScan(in.count(kBytes));
  for (std::size_t i = 0; i < o.getScanSize(); ++i) {
    o.setScanRange(i, in.get<float>());
    o.setScanRangeValidity(i, in.flag());
  }
}

void write(ByteWriter& out, const CObservationGPS& o) {
  write_fix(out, o);
}

void read(ByteReader& in, CObservationGPS& o) {
  read_fix(in, o);
}

void read(ByteReader& in, LoggedCloud& o) {
  read_cloud(in, o);
}

/// Writes it if it is of class T.
template <class T>
bool write_as(Form form, ByteWriter& out, const CObservation& observation) {
  const auto* known = dynamic_cast<const T*>(&observation);
  if (known == nullptr) return false;
  out.put(static_cast<std::uint8_t>(form));
  write(out, *known);
  return true;
}

template <class T>
CObservation::Ptr read_as(ByteReader& in) {
  auto observation = std::make_shared<T>();
  read(in, *observation);
  return observation;
}

void write_mrpt(ByteWriter& out, const CObservation& observation) {
  mrpt::io::CMemoryStream bytes;
  mrpt::serialization::archiveFrom(bytes).WriteObject(&observation);
  out.put(static_cast<std::uint8_t>(Form::kMrpt));
  out.put_text({static_cast<const char*>(bytes.getRawBufferData()),
                static_cast<std::size_t>(bytes.getTotalBytesCount())});
}

/// The class is that which was asked for, whatever the bytes say: MRPT compares the two.
CObservation::Ptr read_mrpt(ByteReader& in, const std::string& class_name,
                            const AskedClasses& asked) {
  if (!asked.contain(class_name)) throw Error("it is of a class that nobody asked for");
  const std::string_view bytes = in.text();
  mrpt::io::CMemoryStream stream;
  stream.assignMemoryNotOwn(bytes.data(), bytes.size());
  auto observation = std::dynamic_pointer_cast<CObservation>(mrpt::rtti::classFactory(class_name));
  mrpt::serialization::archiveFrom(stream).ReadObject(observation.get());
  return observation;
}

CObservation::Ptr read_content(ByteReader& in, const std::string& class_name,
                               const AskedClasses& asked) {
  switch (static_cast<Form>(in.get<std::uint8_t>())) {
    case Form::kAbsent:
      return nullptr;
    case Form::kMrpt:
      return read_mrpt(in, class_name, asked);
    case Form::kOdometry:
      return read_as<CObservationOdometry>(in);
    case Form::kBearingRange:
      return read_as<CObservationBearingRange>(in);
    case Form::kClassed:
      return read_as<Classed>(in);
    case Form::kBeacons:
      return read_as<CObservationBeaconRanges>(in);
    case Form::kScan:
      return read_as<CObservation2DRangeScan>(in);
    case Form::kRobotPose:
      return read_as<CObservationRobotPose>(in);
    case Form::kFix:
      return read_as<CObservationGPS>(in);
    case Form::kCloud:
      return read_as<LoggedCloud>(in);
  }
  throw Error("it has an unknown form");
}

}  // namespace

void write_observation(ByteWriter& out, const LoggedObservation& observation,
                       const AskedClasses& asked) {
  const CObservation& content = *observation.content;
  out.put_text(observation.class_name);
  write_time(out, observation.time);
  out.put_text(content.sensorLabel);
  const bool is_asked = asked.contain(observation.class_name);
  const bool is_whole = is_asked && observation.class_name != kCloudClass;
  if (!is_whole && asked.contain(kCloudClass) && is_cloud_of_log(content)) {
    out.put(static_cast<std::uint8_t>(Form::kCloud));
    write_cloud(out, content);
  } else if (is_asked) {
    write_mrpt(out, content);
  } else if (!write_as<CObservationOdometry>(Form::kOdometry, out, content) &&
             !write_as<CObservationBearingRange>(Form::kBearingRange, out, content) &&
             !write_as<Classed>(Form::kClassed, out, content) &&
             !write_as<CObservationBeaconRanges>(Form::kBeacons, out, content) &&
             !write_as<CObservation2DRangeScan>(Form::kScan, out, content) &&
             !write_as<CObservationRobotPose>(Form::kRobotPose, out, content) &&
             !write_as<CObservationGPS>(Form::kFix, out, content)) {
    out.put(static_cast<std::uint8_t>(Form::kAbsent));
  }
  write_points(out, observation.points);
}

LoggedObservation read_observation(ByteReader& in, const AskedClasses& asked) {
  LoggedObservation observation;
  observation.class_name = in.text();
  observation.time = read_time(in);
  const std::string label(in.text());
  observation.content = read_content(in, observation.class_name, asked);
  if (observation.content) {
    observation.content->timestamp = observation.time;
    observation.content->sensorLabel = label;
  }
  observation.points = read_points(in);
  return observation;
}

}  // namespace hybrid
