// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/observations/classed_bearing_range.h"

#include <fmt/format.h>
#include <mrpt/core/bits_math.h>
#include <mrpt/rtti/CObject.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <ostream>

#include "libhybrid/core/error.h"

IMPLEMENTS_SERIALIZABLE(CObservationClassedBearingRange, mrpt::obs::CObservation, hybrid)

namespace hybrid {
namespace {

/// Limit of detections and classes per observation; larger counts come from damaged files.
constexpr std::uint32_t kMaxCount = 1'000'000;

std::uint32_t read_count(mrpt::serialization::CArchive& in, const char* what) {
  const auto count = in.ReadAs<std::uint32_t>();
  if (count > kMaxCount) {
    throw Error(
        fmt::format("CObservationClassedBearingRange: {} {} in one observation: the file "
                    "is damaged",
                    count, what));
  }
  return count;
}

bool has_own_sigma(const CObservationClassedBearingRange::Detection& d) {
  return d.std_range != 0 || d.std_yaw != 0 || d.std_pitch != 0;
}

std::string best_class(const CObservationClassedBearingRange& observation,
                       const CObservationClassedBearingRange::Detection& detection) {
  const auto& scores = detection.class_scores;
  if (scores.empty() || scores.size() != observation.class_names.size()) return "-";
  const auto best = std::max_element(scores.begin(), scores.end()) - scores.begin();
  return observation.class_names[static_cast<std::size_t>(best)];
}

}  // namespace

/// Version 1 adds sigmas to each detection, version 2 a flag for measured ranges. Observations are
/// stored in the lowest version that holds them.
std::uint8_t CObservationClassedBearingRange::serializeGetVersion() const {
  if (!has_range) return 2;
  return std::any_of(detections.begin(), detections.end(), has_own_sigma) ? 1 : 0;
}

void CObservationClassedBearingRange::serializeTo(mrpt::serialization::CArchive& out) const {
  const bool with_sigmas = serializeGetVersion() >= 1;
  out << timestamp << sensorLabel << sensor_pose << min_range << max_range << fov_yaw << fov_pitch
      << std_range << std_yaw << std_pitch << has_pitch;
  if (serializeGetVersion() >= 2) out << has_range;
  out.WriteAs<std::uint32_t>(class_names.size());
  for (const std::string& name : class_names) out << name;
  out.WriteAs<std::uint32_t>(detections.size());
  for (const Detection& d : detections) {
    out << d.range << d.yaw << d.pitch << d.landmark_id << d.true_landmark_id;
    out.WriteAs<std::uint32_t>(d.class_scores.size());
    for (const float score : d.class_scores) out << score;
    if (with_sigmas) out << d.std_range << d.std_yaw << d.std_pitch;
  }
}

void CObservationClassedBearingRange::serializeFrom(mrpt::serialization::CArchive& in,
                                                    std::uint8_t version) {
  if (version > 2) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  in >> timestamp >> sensorLabel >> sensor_pose >> min_range >> max_range >> fov_yaw >> fov_pitch >>
      std_range >> std_yaw >> std_pitch >> has_pitch;
  has_range = true;
  if (version >= 2) in >> has_range;
  class_names.resize(read_count(in, "classes"));
  for (std::string& name : class_names) in >> name;
  detections.resize(read_count(in, "detections"));
  for (Detection& d : detections) {
    in >> d.range >> d.yaw >> d.pitch >> d.landmark_id >> d.true_landmark_id;
    d.class_scores.resize(read_count(in, "class scores"));
    for (float& score : d.class_scores) in >> score;
    if (version >= 1) in >> d.std_range >> d.std_yaw >> d.std_pitch;
  }
}

void CObservationClassedBearingRange::getDescriptionAsText(std::ostream& out) const {
  CObservation::getDescriptionAsText(out);
  out << fmt::format("Sensor pose on the robot: {}\n", sensor_pose.asString());
  out << fmt::format("Range limits: {} to {} m, field of view: {:.1f} x {:.1f} deg\n", min_range,
                     max_range, mrpt::RAD2DEG(fov_yaw), mrpt::RAD2DEG(fov_pitch));
  out << fmt::format(
      "Sigmas: range {}, yaw {:.4f} deg, pitch {}\n",
      has_range ? fmt::format("{} m", std_range) : "not measured", mrpt::RAD2DEG(std_yaw),
      has_pitch ? fmt::format("{:.4f} deg", mrpt::RAD2DEG(std_pitch)) : "not measured");
  out << fmt::format("Classes: {}\n", fmt::join(class_names, " "));
  out << fmt::format("{} detections: range[m] yaw[deg] pitch[deg] id true_id class (scores)\n",
                     detections.size());
  for (const Detection& d : detections) {
    out << fmt::format("  {:8.3f} {:8.2f} {:8.2f} {:5} {:5} {} ({:.3f})\n", d.range,
                       mrpt::RAD2DEG(d.yaw), mrpt::RAD2DEG(d.pitch), d.landmark_id,
                       d.true_landmark_id, best_class(*this, d), fmt::join(d.class_scores, " "));
  }
}

std::string CObservationClassedBearingRange::exportTxtHeader() const {
  return "DETECTIONS {RANGE YAW PITCH ID TRUE_ID CLASS}*DETECTIONS";
}

std::string CObservationClassedBearingRange::exportTxtDataRow() const {
  std::string row = fmt::format("{}", detections.size());
  for (const Detection& d : detections) {
    row += fmt::format(" {} {} {} {} {} {}", d.range, d.yaw, d.pitch, d.landmark_id,
                       d.true_landmark_id, best_class(*this, d));
  }
  return row;
}

}  // namespace hybrid

// As HYBRID_REGISTER_PLUGIN does: behind what the class is, in one file.
[[maybe_unused]] static const bool is_registered =
    (mrpt::rtti::registerClass(CLASS_ID(hybrid::CObservationClassedBearingRange)), true);
