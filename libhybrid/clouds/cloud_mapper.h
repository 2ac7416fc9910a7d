// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "libhybrid/clouds/cloud_closures.h"
#include "libhybrid/clouds/cloud_tracker.h"
#include "libhybrid/online/closure_graph.h"

namespace HYBRID_API hybrid {

struct CloudMapperOptions {
  CloudTrackerOptions tracker;
  CloudClosureOptions closures;
  OnlineSelectionOptions selection;
};

/// A path by the clouds of a sensor, in the frame of its first one: each is matched with those
/// before, and places seen before close loops, of which any may be false (see OnlineSelection).
class CloudMapper {
 public:
  explicit CloudMapper(const CloudMapperOptions& options = {});

  /// Before the first cloud: where that is, in the frame of clouds of earlier drives, which are
  /// searched for closures, too.
  void adopt(std::vector<StoredCloud> stored, const UncertainMotion3& start);

  /// `points` are in the frame of the robot [m], seen from `sensor`; `odometry` is the motion since
  /// the cloud before, where it is known. See CloudTracker::track for `is_at_once`.
  TrackedCloud add(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& sensor,
                   const std::optional<UncertainMotion3>& odometry = std::nullopt,
                   bool is_at_once = false);
  /// Decides all closures again and solves to convergence.
  void finish();

  SE3 pose(std::size_t cloud) const { return graph_.pose(cloud); }
  /// Where cloud b is, seen from cloud a.
  UncertainMotion3 relation(std::size_t a, std::size_t b) const { return graph_.relation(a, b); }
  const CloudTracker& tracker() const { return tracker_; }
  const std::vector<StoredCloud>& stored() const { return search_.stored(); }
  const std::vector<KnownPlace<SE3>>& places() const { return graph_.places(); }
  const std::vector<CloudClosure>& closures() const { return graph_.closures(); }
  /// What became of closures that others have found, so far.
  ProposedCount proposed() const { return search_.proposed(tracker_.clouds()); }
  /// By closure; see OnlineSelection.
  ClosureStatus status(std::size_t closure) const { return graph_.selection().status(closure); }
  std::vector<ClosureDecision> decisions() const { return graph_.selection().decisions(); }

 private:
  std::vector<CloudClosure> search();

  CloudTracker tracker_;
  CloudClosureSearch search_;
  ClosureGraph<SE3> graph_;
};

}  // namespace hybrid
