// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/bridge/timed_pose.h"
#include "mrpt_plugins/input/keyframe_source.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// Where robots were between keyframes, by odometry or by what follows their scans, kept for the
/// outputs of a run: 112 bytes for each entry. Once there are more entries of odometry than a
/// limit, every second of them is left out; those of scans all stay.
class PathArchive {
 public:
  static constexpr std::size_t kMost = 1'000'000;  // entries of odometry
  /// Of all curves together, so that pages and pictures stay small.
  static constexpr std::size_t kMostDrawn = 10'000;

  /// `keeps_scans`: scans have poses of their own; `is_3d`: else odometry counts in the plane
  /// alone.
  PathArchive(bool keeps_scans, bool is_3d, std::size_t most = kMost)
      : keeps_scans_(keeps_scans), is_3d_(is_3d), most_(most) {}

  /// Takes the next keyframe of the map; `is_matched`: its motion is that of scans, not odometry.
  void add(const Keyframe& keyframe, bool is_matched = false);
  /// The last keyframe of each robot so far, its place in MapResult::trajectory.
  struct Last {
    std::size_t keyframe = 0;
    double time = 0;
  };
  const std::map<std::size_t, Last>& last_of() const { return last_of_; }
  /// Where a robot was after its last keyframe, seen from it.
  void end(std::size_t robot, const std::vector<PoseBetween>& rest);

  /// The path of robot `robot` in order of time, from the poses of all keyframes, at the keyframes,
  /// scans and entries of odometry. Between two keyframes it is that of odometry, with what is
  /// missing to the second one shared out by time.
  Trajectory path(const Trajectory& keyframes, std::size_t robot = 0) const;
  /// The same by odometry alone, from its poses of the keyframes: without scans, and without poses
  /// where scans tell the motion.
  Trajectory reckoned_path(const Trajectory& keyframes, std::size_t robot = 0) const;

  /// The entries of odometry as both paths are drawn: without those that are within a centimetre of
  /// the line between others, or, where too many are left, within twice as much and so on.
  PathCurves curves(const Trajectory& keyframes) const;
  PathCurves reckoned_curves(const Trajectory& keyframes) const;

 private:
  struct Entry {
    double time = 0;
    Eigen::Matrix<double, 3, 4> T_keyframe_robot;
    bool is_scan = false, is_odometry = false;
  };
  struct Step {
    std::size_t robot = 0;
    bool is_matched = false;
    std::vector<Entry> entries;
    // Since the keyframe before; null where that is not known, or nothing is between.
    std::unique_ptr<const Eigen::Isometry3d> T_before_keyframe;
  };
  enum class Kind { kAll, kOdometry, kReckoned };

  void add_odometry(double end, const std::vector<PoseBetween>& poses, std::vector<Entry>& entries);
  void thin_out();
  void thin_out(std::vector<Entry>& entries, bool& keeps);
  static bool counts(const Step& step, const Entry& entry, Kind kind);
  void add_poses(std::size_t k, std::optional<std::size_t> before, const Trajectory& keyframes,
                 Kind kind, Trajectory& out) const;
  void add_rest(std::size_t robot, const Trajectory& keyframes, Trajectory& out) const;
  Trajectory path(const Trajectory& keyframes, std::size_t robot, Kind kind) const;
  PathCurves curves(const Trajectory& keyframes, Kind kind) const;

  bool keeps_scans_, is_3d_;
  std::size_t most_;
  std::size_t count_ = 0;  // entries of odometry alone
  std::vector<Step> steps_;
  std::map<std::size_t, Step> rests_;  // by robot
  std::map<std::size_t, Last> last_of_;
};

}  // namespace hybrid
