// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "libhybrid/clouds/cloud_alignment.h"
#include "libhybrid/clouds/sweep_calibration.h"

namespace HYBRID_API hybrid {

/// Lengths are shares of the reach of the sensor, see reach_of().
struct CloudTrackerOptions {
  double spacing = 0.03;  ///< of the points that are kept and matched
  double map_length = 4;  ///< way that a local map spans
  /// Share of the points on surfaces below which a match is none.
  double min_inliers = 0.3;
  std::size_t most_points = 3000;  ///< of a cloud that are matched, evenly chosen
};

/// What the surfaces of a stretch of the path look like. The frame is that of its anchor.
struct LocalCloud {
  std::size_t anchor = 0;          ///< cloud
  std::vector<SE3> poses;          ///< of the clouds from the anchor on
  std::vector<double> travelled;   ///< way to these from the first cloud [m]
  std::vector<CloudPoint> points;  ///< once it no longer grows
};

/// What is known of a cloud beside those before.
struct TrackedCloud {
  std::size_t cloud = 0;
  SE3 T_before_cloud;    ///< in the frame of the cloud before
  double inliers = 0;    ///< share of its points on surfaces of the local map
  bool is_lost = false;  ///< it agreed with no surface; the second in a row begins a local map
  /// From a cloud of the local map, by a match.
  struct Match {
    std::size_t from = 0;
    UncertainMotion3 measured;
  };
  std::optional<Match> match;
};

/// Follows a sensor by its clouds, each matched with the surfaces of those before. Local maps
/// overlap by half.
class CloudTracker {
 public:
  explicit CloudTracker(const CloudTrackerOptions& options = {}) : options_(options) {}

  /// `points` are in the frame of the robot, seen from `sensor`; `odometry` is the motion since the
  /// cloud before, where it is known; `is_at_once` says that all points are where they would have
  /// been seen at the stamp.
  TrackedCloud track(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& sensor,
                     const std::optional<UncertainMotion3>& odometry, bool is_at_once = false);

  /// In the order of their anchors; the last one still grows.
  const std::vector<LocalCloud>& local_maps() const { return maps_; }
  /// The surfaces of the last local map; null before the first cloud.
  const CloudSurfaces* surfaces() const { return surfaces_ ? &*surfaces_ : nullptr; }
  const SweepCalibration& sweep() const { return sweep_; }
  std::size_t clouds() const { return clouds_; }
  std::size_t lost() const { return lost_; }    ///< clouds that agreed with no local map
  std::size_t blind() const { return blind_; }  ///< clouds with hardly a surface
  double reach() const { return reach_; }       ///< of the sensor [m]; 0 before the first cloud

 private:
  using PoseShifts = SweepCalibration::PoseShifts;
  /// What a cloud of the last local map has added to it, perhaps nothing.
  struct Added {
    PoseShifts pose = PoseShifts::Zero();
    std::vector<CloudPoint> points;
    std::vector<SurfaceShifts> shifts;  // of the points, wherever the cloud is
  };
  CloudAlignment aligned(const std::vector<CloudPoint>& points, const SE3& predicted,
                         const Matrix6& covariance, bool has_odometry) const;
  bool is_better(const CloudAlignment& other, const CloudAlignment& expected,
                 const std::vector<CloudPoint>& points) const;
  void make_surfaces();
  void add_surfaces(const Added& added, const SE3& pose);
  void begin_map();
  void begin_map_anew();
  void add(const SE3& pose, const PoseShifts& shifts, bool agrees);
  TrackedCloud begin(const std::optional<UncertainMotion3>& odometry);

  CloudTrackerOptions options_;
  double reach_ = 0;
  bool has_matched_ = false;  // a cloud agreed with another, by lengths that come from the reach
  std::optional<CloudSurfaces> surfaces_, coarse_;  // of the last local map
  std::vector<LocalCloud> maps_;
  std::vector<Added> recent_;  // by cloud of the last local map
  SweepCalibration sweep_;
  std::vector<CloudPoint> newest_;
  SE3 last_motion_;
  SE3 since_added_;  // motion since points were added
  std::size_t clouds_ = 0, lost_ = 0, blind_ = 0;
  std::size_t lost_in_row_ = 0;
};

}  // namespace hybrid
