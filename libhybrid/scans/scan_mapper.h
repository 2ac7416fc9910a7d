// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/online/closure_graph.h"
#include "libhybrid/scans/laser_scan.h"
#include "libhybrid/scans/scan_closures.h"
#include "libhybrid/scans/scan_tracker.h"

namespace HYBRID_API hybrid {

struct ScanMapperOptions {
  ScanPointOptions points;
  ScanTrackerOptions tracker;
  ScanClosureOptions closures;
  OnlineSelectionOptions selection;
};

/// Maps by planar laser scans alone: a ScanTracker in front, a graph of keyframes behind, and the
/// closures between them decided by OnlineSelection.
class ScanMapper {
 public:
  explicit ScanMapper(const ScanMapperOptions& options = {});

  /// Before the first scan: where that is, in the frame of scans of earlier drives, which are
  /// searched for closures, too.
  void adopt(std::vector<StoredScans> stored, const UncertainMotion& start);

  /// `odometry` is the motion since the last scan, if known. If it throws, nothing has changed.
  TrackedScan add(const LaserScan& scan, const std::optional<SE2>& odometry = std::nullopt);
  /// The same for points in the frame of the robot, e.g. of several scanners.
  TrackedScan add(const std::vector<SurfacePoint>& points, const std::optional<SE2>& odometry,
                  KeyframeRule rule = KeyframeRule::kByMotion);
  /// A place to go back to while no keyframe has come since, as where one of the scans that belong
  /// together cannot be used.
  struct Mark {
    ScanTracker::Mark tracker;
    std::size_t scans = 0;
    double next_search = 0.0;
  };
  Mark mark() const { return {tracker_.mark(), scans_.size(), search_.next()}; }
  void roll_back(const Mark& mark);
  /// Decides all closures again and solves to convergence.
  void finish();

  /// Pose of every scan so far at the present estimate, in order.
  std::vector<SE2> path() const;
  /// The estimate of a keyframe.
  SE2 pose(std::size_t keyframe) const { return graph_.pose(keyframe); }
  /// Where keyframe b is, seen from keyframe a.
  UncertainMotion relation(std::size_t a, std::size_t b) const { return graph_.relation(a, b); }
  const ScanTracker& tracker() const { return tracker_; }
  const std::vector<StoredScans>& stored() const { return search_.stored(); }
  const std::vector<KnownPlace<SE2>>& places() const { return graph_.places(); }
  const std::vector<ScanClosure>& closures() const { return graph_.closures(); }
  /// By closure; see OnlineSelection.
  ClosureStatus status(std::size_t closure) const { return selection().status(closure); }
  std::vector<ClosureDecision> decisions() const { return selection().decisions(); }
  const OnlineSelection& selection() const { return graph_.selection(); }

 private:
  struct Placed {
    std::size_t keyframe = 0;
    SE2 T_keyframe_scan;
  };
  void add_keyframe(const TrackedScan& tracked);
  UncertainMotion motion_to(const TrackedScan& tracked) const;
  std::vector<ScanClosure> search(const SE2& here, const TrackedScan& tracked);

  ScanMapperOptions options_;
  ScanTracker tracker_;
  ScanClosureSearch search_;
  ClosureGraph<SE2> graph_;
  std::vector<Placed> scans_;
};

}  // namespace hybrid
