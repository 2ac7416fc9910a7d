// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "libhybrid/association/prediction.h"
#include "libhybrid/clouds/cloud_closures.h"
#include "libhybrid/clouds/cloud_view.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/landmarks/known_map.h"
#include "libhybrid/scans/laser_scan.h"
#include "libhybrid/scans/scan_closures.h"

namespace HYBRID_API hybrid {

/// Times between a measurement and a look at its place [s].
struct AgreementOptions {
  /// Soon after: later than errors of sensors last, and before odometry has lost its way.
  double near_from = 3, near_to = 20;
  /// Much later: the path alone brings such looks to the same place. In a log that is shorter than
  /// twice that it is half of the log, but not less than `near_to`.
  double far_from = 60;
};

/// How often later looks at a place find what was measured there: soon after, which needs no map,
/// and much later, which needs a path that is right. Both are compared at like distances and
/// directions of view, so that what a sensor overlooks or takes amiss enters both.
struct Agreement {
  /// Share of looks that find a place soon again wherever the path holds for seconds. Chance finds
  /// less, which is nothing to compare with: the late share is compared with this instead.
  static constexpr double kLeastSoon = 0.1;

  double soon = 0, late = 0;  ///< shares of looks that found it
  double ratio = 0;           ///< late over soon, or `kLeastSoon`; about 1 where the path is right
  double sigma = 0;           ///< standard deviation of the ratio, by stretches of the log
  double far_from = 0;        ///< how much later the late looks were, at least [s]
  std::size_t looks = 0;      ///< late ones, with soon ones to compare with
  double judged = 0;          ///< share of the measured places that had such looks
  /// The ratio of what was measured in one stretch of the log.
  struct Stretch {
    double time = 0;  ///< when it began [s]
    double ratio = 0;
    std::size_t looks = 0;
    std::size_t places = 0;  ///< that had late looks
  };
  std::vector<Stretch> stretches;  ///< in order of time; those with looks alone
};

/// What a sensor detected at one time, laid out by a path.
struct PlacedDetections {
  double time = 0;        ///< [s]
  int robot = 0;          ///< looks of different robots are late whatever the time
  int sensor = 0;         ///< its range and field of view are learnt from its detections
  bool is_3d = true;      ///< else two numbers each, in the plane of the sensor
  bool has_range = true;  ///< else ranges are 0, and the sensor tells directions alone
  Eigen::Isometry3d T_map_sensor = Eigen::Isometry3d::Identity();
  std::vector<MeasuredPoint> seen;  ///< range and angles
};

/// The agreement over time of detections; in any order. No association, no landmark and no prior is
/// used, only which places were detected again when they were in view. What sensors of directions
/// see is at a place where its directions of some seconds cross; it is found again in any direction
/// that leads there. It takes at most 8,000 places and 200 looks at each, evenly spread.
Agreement agreement_of_detections(std::vector<PlacedDetections> frames,
                                  const AgreementOptions& options = {});

/// A scan laid out by a path; it must outlive the call.
struct PlacedScan {
  double time = 0;  ///< [s]
  int robot = 0;
  SE2 T_map_sensor;
  bool is_upside_down = false;  ///< rays that turn to the left are seen turning to the right
  const LaserScan* scan = nullptr;
};

/// The same of planar scans: whether rays towards a place end at the surface that was measured
/// there, or go through it. Rays that end before it tell nothing.
Agreement agreement_of_scans(std::vector<PlacedScan> scans, const AgreementOptions& options = {});

/// A cloud laid out by a path; its view must outlive the call.
struct PlacedCloud {
  double time = 0;  ///< [s]
  int robot = 0;
  SE3 T_map_robot;
  const CloudView* view = nullptr;

  Eigen::Vector3d sensor() const { return T_map_robot * view->sensor().cast<double>(); }
};

/// The same of clouds in space, from sensors of that reach [m] (see reach_of). Each is compared
/// with all others: some hundred are enough.
Agreement agreement_of_clouds(std::vector<PlacedCloud> clouds, double reach,
                              const AgreementOptions& options = {});

/// The same of scans in a known map: in place of what they measured much earlier or later, the
/// surfaces of the map are looked at.
Agreement agreement_with_map(std::vector<PlacedScan> scans, const std::vector<StoredScans>& map,
                             const AgreementOptions& options = {});

/// The same of detections and the landmarks of a map.
Agreement agreement_with_map(std::vector<PlacedDetections> frames,
                             const std::vector<KnownLandmark>& map,
                             const AgreementOptions& options = {});

/// The same of clouds.
Agreement agreement_with_map(std::vector<PlacedCloud> clouds, double reach,
                             const std::vector<StoredCloud>& map,
                             const AgreementOptions& options = {});

}  // namespace hybrid
