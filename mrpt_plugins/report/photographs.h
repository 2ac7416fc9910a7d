// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservationImage.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/rawlog/image_decoder.h"

namespace HYBRID_API hybrid {

/// Class of the observations that have photographs, for a LogRequest.
inline constexpr const char* kPhotographClass = "mrpt::obs::CObservationImage";

/// What the cameras of the robot saw, made small, for the page of a run.
class Photographs {
 public:
  static constexpr int kWidth = 320;                  ///< Wider ones are made smaller [pixels].
  static constexpr std::size_t kMostBytes = 2000000;  ///< Of all together, as JPEG.

  /// Keeps the images among the observations of a keyframe. Each time they are too many, every
  /// other photograph goes, and of those to come only every second (fourth, eighth ..) is kept.
  /// Images that the log only names are looked for where MRPT has them: beside F.rawlog in the
  /// folder F_Images, or else Images: PNG and JPEG files of less than 50 million pixels, no links.
  /// Each is decoded once, in a process of its own (image_decoder.h), however often it is named.
  void add(int keyframe, const std::vector<mrpt::obs::CObservation::Ptr>& observations,
           const std::string& rawlog);

  /// For the page; web/src/data.ts has the types.
  nlohmann::ordered_json json() const;

 private:
  struct Camera {
    double fx, fy, cx, cy;  // [pixels of the small picture]
    Eigen::Isometry3d T_robot_camera;
  };
  struct Photograph {
    int keyframe = 0;
    std::string sensor;
    int width = 0, height = 0;
    std::string jpeg;
    std::optional<Camera> camera;
  };

  /// A picture as it is kept: no JPEG where it cannot be read.
  struct Small {
    int width = 0, height = 0;
    std::string jpeg;
  };

  static std::optional<Camera> camera_of(const mrpt::obs::CObservationImage& observation,
                                         const Small& small);
  void keep(int keyframe, const mrpt::obs::CObservationImage& observation,
            const std::string& rawlog);
  Small small_of(const mrpt::img::CImage& image, const std::string& rawlog);
  void thin();

  std::vector<Photograph> kept_;
  std::size_t bytes_ = 0;       // of those kept
  std::size_t count_ = 0;       // of all so far
  std::size_t every_ = 1;       // which of them are kept
  std::size_t unreadable_ = 0;  // of those tried
  ImageDecoder decoder_{kWidth};
  std::map<std::string, Small> files_;  // those named lately, by their path
};

}  // namespace hybrid
