// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/scans/rest_watch.h"
#include "libhybrid/scans/scan_match.h"
#include "libhybrid/scans/scan_motion.h"
#include "libhybrid/scans/scan_points.h"

namespace HYBRID_API hybrid {

struct ScanTrackerOptions {
  double keyframe_distance = 0.5;  ///< [m] between keyframes
  double keyframe_turn = 0.35;     ///< [rad]
  /// Where fewer of the points than this lie on the local map, keyframes are denser.
  double familiar = 0.6;
  double map_length = 8.0;         ///< way that a local map spans [m]
  std::size_t map_keyframes = 80;  ///< and keyframes, at most
  /// Share of the points on surfaces below which a match is none.
  double min_inliers = 0.3;
};

/// The points of a keyframe and how far the robot had come.
struct ScanKeyframe {
  std::vector<SurfacePoint> points;  ///< in the frame of the robot
  ScanView view;                     ///< of these
  double travelled = 0.0;            ///< way to it from the first [m]
  /// Of its pose in the map that it was matched with, in its tangent.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// A stretch of keyframes in the frame of its first one, the anchor.
struct LocalMap {
  std::size_t anchor = 0;
  std::vector<SE2> poses;  ///< of the keyframes from the anchor on, in the frame of that
  bool is_blind = true;    ///< none of them has more than a few points
};

/// A measured motion between two keyframes.
struct KeyframeMotion {
  std::size_t from = 0;
  UncertainMotion measured;
  double inliers = 1.0;  ///< share of the points on surfaces, if by a match
};

/// Where a scan is.
struct TrackedScan {
  std::size_t keyframe = 0;  ///< the last one, which may be this scan
  bool is_keyframe = false;
  SE2 T_keyframe_scan;
  SE2 T_before_scan;     ///< the same, of a keyframe in the frame of the one before
  double inliers = 1.0;  ///< share of its points on surfaces of the local map
  // For a keyframe but the first:
  std::optional<KeyframeMotion> match;  ///< from a keyframe of the local map
  /// From the keyframe before, without scale and drift; a steady motion where there is none.
  KeyframeMotion odometry;
};

enum class KeyframeRule { kByMotion, kAlways, kNever };

/// What a ScanTracker notes of the last scans.
class ScanTrackerState {
 protected:
  std::shared_ptr<const SurfaceMap> surfaces_ = std::make_shared<SurfaceMap>();
  std::shared_ptr<const MatchTarget> target_;  // of the last local map, once needed
  RestWatch rest_;
  OdometryNoise noise_;
  SE2 pose_;                       // of the last scan in the last local map
  SE2 last_motion_;                // between the last two scans
  SE2 since_keyframe_;             // by odometry, corrected
  SE2 stated_;                     // the same as odometry states it
  double way_ = 0.0, turn_ = 0.0;  // by odometry, since the last keyframe
  bool has_odometry_ = true;       // for every scan since the last keyframe
  bool is_lost_ = false;           // a scan since the last keyframe agreed with no map
  bool counts_ = false;            // odometry has told most of the last motion
  bool is_carried_ = false;        // it was carried to such a scan
  bool was_lost_ = false;          // the same at the last keyframe
  std::size_t lost_ = 0, carried_ = 0;
  // Errors of the predictions of the last scans, decaying means [m].
  double odometry_error_ = 0.0, steady_error_ = 0.0;
};

/// Follows a robot by its scans: each is aligned with a local map of the last metres, from where
/// odometry, if there is any, or a steady motion predicts it. Knows no map as a whole.
class ScanTracker : private ScanTrackerState {
 public:
  explicit ScanTracker(const ScanTrackerOptions& options = {}) : options_(options) {}

  /// `points` are in the frame of the robot; `odometry` is the motion since the last scan. One that
  /// is not finite, or of more than 100 m, is none.
  TrackedScan track(const std::vector<SurfacePoint>& points, const std::optional<SE2>& odometry,
                    KeyframeRule rule = KeyframeRule::kByMotion);

  const std::vector<ScanKeyframe>& keyframes() const { return keyframes_; }
  /// Local maps in the order of their anchors; the last one still grows.
  const std::vector<LocalMap>& local_maps() const { return maps_; }
  const OdometryNoise& odometry_noise() const { return noise_; }
  std::size_t lost() const { return lost_; }  ///< scans that agreed with no local map
  /// Of these, those to which the robot was moved while odometry rested.
  std::size_t carried() const { return carried_; }
  /// All points of a local map, in its frame.
  std::vector<SurfacePoint> points(const LocalMap& map) const;

  /// A place to go back to while one keyframe at most has come since.
  struct Mark {
    ScanTrackerState state;
    std::size_t keyframes = 0, maps = 0;
    std::size_t count = 0;  // of keyframes in the last local map
    bool is_blind = true;   // that map
  };
  Mark mark() const;
  void roll_back(const Mark& mark);

 private:
  std::optional<SE2> advance(const std::optional<SE2>& stated);
  Eigen::Matrix3d prior(const SE2& motion, bool by_odometry) const;
  void search(const std::vector<SurfacePoint>& points, const UncertainMotion& predicted,
              const SearchWindow& window, ScanAlignment& best);
  double share_in_view(const std::vector<SurfacePoint>& points, const SE2& pose) const;
  ScanAlignment aligned(const std::vector<SurfacePoint>& points, const UncertainMotion& predicted);
  std::size_t reference(const SE2& pose, const Eigen::Matrix3d& covariance) const;
  KeyframeMotion odometry_motion(const TrackedScan& scan) const;
  void measure(const ScanAlignment& found, const SE2& pose, bool good, TrackedScan& result);
  void compare_predictions(const SE2& odometry, const SE2& motion);
  bool is_due(const SE2& from_last, double inliers, KeyframeRule rule) const;
  void add_keyframe(const std::vector<SurfacePoint>& points, const SE2& pose,
                    const Eigen::Matrix3d& covariance);
  void begin_keyframe();
  void begin_map();
  void add_to_map(std::size_t keyframe, const SE2& pose);

  ScanTrackerOptions options_;
  std::vector<ScanKeyframe> keyframes_;
  std::vector<LocalMap> maps_;
};

}  // namespace hybrid
