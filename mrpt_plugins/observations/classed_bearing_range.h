// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>

#include <cstdint>
#include <string>
#include <vector>

#include "libhybrid/export.h"
#include "mrpt_plugins/mrpt_version.h"

namespace HYBRID_API hybrid {

/// Ranges and directions to landmarks with class scores, as measured by an object detector on a
/// robot. Angles are those of mrpt::obs::CObservationBearingRange: the point is at CPose3D(0, 0, 0,
/// yaw, pitch, 0) * (range, 0, 0) in the frame of the sensor, so that a positive pitch points down.
/// Lengths are in metres, angles in radians.
class CObservationClassedBearingRange : public mrpt::obs::CObservation {
  DEFINE_SERIALIZABLE(CObservationClassedBearingRange, hybrid)

 public:
  struct Detection {
    float range = 0, yaw = 0, pitch = 0;
    /// mrpt::obs::INVALID_LANDMARK_ID if the sensor does not identify landmarks.
    std::int32_t landmark_id = mrpt::obs::INVALID_LANDMARK_ID;
    /// The true landmark, for evaluation only: known to a simulator, or INVALID_LANDMARK_ID for
    /// spurious detections and where the truth is unknown.
    std::int32_t true_landmark_id = mrpt::obs::INVALID_LANDMARK_ID;
    /// Probability of each entry of `class_names`; empty if not classified.
    std::vector<float> class_scores;
    /// Sigmas of this detection; 0: those of the sensor.
    float std_range = 0, std_yaw = 0, std_pitch = 0;
  };

  mrpt::poses::CPose3D sensor_pose;    ///< On the robot.
  float min_range = 0, max_range = 0;  ///< 0: no limit.
  float fov_yaw = 0, fov_pitch = 0;    ///< Full fields of view.
  float std_range = 0, std_yaw = 0, std_pitch = 0;
  bool has_range =
      true;  ///< False for a sensor of directions only: range and std_range have no meaning.
  bool has_pitch = true;  ///< False for a planar sensor: pitch and std_pitch have no meaning.
  std::vector<std::string> class_names;
  std::vector<Detection> detections;

  HYBRID_DEFINE_SENSOR_POSE(sensor_pose)
  void setSensorPose(const mrpt::poses::CPose3D& pose) override { sensor_pose = pose; }
  void getDescriptionAsText(std::ostream& out) const override;
  bool exportTxtSupported() const override { return true; }
  std::string exportTxtHeader() const override;
  /// The number of detections, then six columns for each detection.
  std::string exportTxtDataRow() const override;
};

}  // namespace hybrid
