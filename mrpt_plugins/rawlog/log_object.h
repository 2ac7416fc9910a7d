// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/math/TPoint3D.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/poses/CPosePDFGaussian.h>

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// One observation of a log.
struct LoggedObservation {
  std::string class_name;  ///< As MRPT registers it.
  mrpt::system::TTimeStamp time = INVALID_TIMESTAMP;
  /// Null for a class that nobody asked for.
  mrpt::obs::CObservation::Ptr content;
  /// What it tells of surfaces, seen from the robot [m]; where asked for.
  std::vector<mrpt::math::TPoint3Df> points;
};

/// How the robot moved: not told, in the plane or in space, with MRPT's covariances.
using LoggedMotion =
    std::variant<std::monostate, mrpt::poses::CPosePDFGaussian, mrpt::poses::CPose3DPDFGaussian>;

/// A CActionCollection: the time of its first action, and its motion.
struct LoggedActions {
  mrpt::system::TTimeStamp time = INVALID_TIMESTAMP;
  LoggedMotion motion;
};

/// A CSensoryFrame.
struct LoggedFrame {
  std::vector<LoggedObservation> observations;
};

/// A map of points, or one of observations turned into points; where asked for.
struct LoggedPoints {
  std::vector<mrpt::math::TPoint3Df> points;
};

/// Anything else.
struct OtherObject {
  std::string class_name;
};

/// One object of a rawlog, as far as this program uses it.
using LogObject =
    std::variant<LoggedActions, LoggedFrame, LoggedObservation, LoggedPoints, OtherObject>;

class ParsedLogs;

/// What is wanted of a log beyond what this program knows: odometry, poses of the robot, bearing
/// and range, classed bearing and range, ranges to beacons, planar laser scans, satellite fixes.
struct LogRequest {
  /// Classes of further observations, with or without namespace. For CObservationPointCloud, clouds
  /// of depth cameras and lidars come as such, too, unless their classes are named.
  std::vector<std::string> classes;
  /// The points of all observations and maps.
  bool points = false;
  /// Where to find logs that were parsed before, and to keep this one; null: nowhere.
  std::shared_ptr<ParsedLogs> parsed = nullptr;
};

}  // namespace hybrid
