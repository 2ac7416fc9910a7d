// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "libhybrid/scans/scan_mapper.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace HYBRID_API hybrid {

/// How a robot moved to a keyframe and to the scans since the one before, by matches of scans.
struct ScanMotion {
  /// Pose of the keyframe in the frame of the one before of the same robot, where that had scans.
  std::optional<SE2> T_before_keyframe;
  std::vector<SE2> T_keyframe_robot;  ///< by scan of the frame
  /// The odometry to the keyframe without the scale and drift that such matches tell, and its
  /// covariance, measured by them: tangent (x, y [m], angle [rad]) of a right perturbation.
  std::optional<UncertainMotion> odometry;
};

/// What a mapping plugin is besides that follows robots by their scans. Keyframes with scans stay
/// in the graph of a bounded window: it may tie any of them to later ones, or set it free again.
class ScanFollower {
 public:
  virtual ~ScanFollower() = default;

  /// Called before each MappingPlugin::observe: whose frame it is, and whether odometry to it is
  /// known; else Frame::T_map_robot is the pose before.
  virtual void expect(std::size_t robot, bool has_odometry) = 0;
  /// What the scans of the frame that was observed last tell of the motion to it.
  virtual std::optional<ScanMotion> scan_motion() const = 0;
  /// Before the first frame of a robot: scans of earlier drives, and where it starts among them.
  virtual void adopt_scans(std::size_t robot, const std::vector<StoredScans>& stored,
                           const UncertainMotion& start) = 0;
  /// The map by the scans of a robot alone, in a frame of its own; null before its first frame.
  virtual const ScanMapper* scan_mapper(std::size_t robot) const = 0;
  /// What the scans of all robots saw, by local maps; anchors are places in MapResult::trajectory.
  virtual std::vector<LocalScans> local_scans() const = 0;
  /// Closures so far between keyframes of the map, with the present decisions.
  virtual std::vector<MeasuredClosure<SE2>> scan_closures() const = 0;
};

}  // namespace hybrid
