// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "libhybrid/clouds/cloud_mapper.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace HYBRID_API hybrid {

/// What clouds have seen along a stretch of the path.
struct LocalView {
  std::size_t anchor = 0;          ///< place in MapResult::trajectory
  std::vector<CloudPoint> points;  ///< in the frame of that
  double spacing = 0;              ///< between these [m]
};

/// What a mapping plugin is besides that follows robots by clouds of points in space.
class CloudFollower {
 public:
  virtual ~CloudFollower() = default;

  /// Before the first frame of a robot: clouds of earlier drives, and where it starts among them.
  virtual void adopt_clouds(std::size_t robot, const std::vector<StoredCloud>& stored,
                            const UncertainMotion3& start) = 0;
  /// The map by the clouds of a robot alone, in a frame of its own; null before its first frame.
  virtual const CloudMapper* cloud_mapper(std::size_t robot) const = 0;
  /// Closures so far between keyframes of the map, with the present decisions.
  virtual std::vector<MeasuredClosure<SE3>> cloud_closures() const = 0;
  /// What the clouds of all robots saw.
  virtual std::vector<LocalView> local_views() const = 0;
};

/// The plugin that follows clouds; null where none does.
CloudFollower* cloud_follower_of(const std::vector<std::shared_ptr<MappingPlugin>>& plugins);

}  // namespace hybrid
