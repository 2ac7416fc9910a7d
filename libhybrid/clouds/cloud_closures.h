// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <vector>

#include "libhybrid/clouds/cloud_tracker.h"
#include "libhybrid/scans/likelihood_field.h"

namespace HYBRID_API hybrid {

/// Lengths are shares of the reach of the sensor, see reach_of().
struct CloudClosureOptions {
  double every = 0.5;              ///< way between searches
  double view = 1;                 ///< distance at which places share surfaces
  double max_reach = 2;            ///< half the width of the window of a search, at most
  double max_turn = 0.8;           ///< and of its angle about the vertical, at most [rad]
  int most_maps = 4;               ///< local maps searched for one cloud, at most
  double min_inliers = 0.5;        ///< modes of a smaller share are left out
  std::size_t most_points = 2000;  ///< that are matched, evenly chosen
};

/// A place where a cloud may be, in the frame of an earlier one.
struct CloudClosure {
  std::size_t from = 0, to = 0;  ///< clouds
  UncertainMotion3 pose;         ///< of `to` in the frame of `from`
  double inliers = 0;            ///< share of the points that lie on a surface
  int modes = 1;                 ///< that the same search has found, of which at most one is true
  std::size_t first_mode = 0;    ///< number of the first of them, of all found for the cloud
};

/// Searches earlier local maps for the place of the newest cloud. Maps of walls and poles, seen
/// from above, tell all poses in the plane at which these may lie on each other; from each, and
/// from the pose that the path predicts, the surfaces are aligned in space.
class CloudClosureSearch {
 public:
  /// Estimate of the pose of a cloud.
  using Poses = std::function<SE3(std::size_t cloud)>;
  /// Estimate of the pose of cloud b in the frame of a.
  using Relation = std::function<UncertainMotion3(std::size_t a, std::size_t b)>;

  explicit CloudClosureSearch(const CloudClosureOptions& options = {}) : options_(options) {}

  /// All modes of each place; none while the way since the last search is short.
  std::vector<CloudClosure> search(const CloudTracker& tracker, const Poses& poses,
                                   const Relation& relation);

 private:
  /// A complete local map as it is searched.
  struct Target {
    CloudSurfaces surfaces;
    LikelihoodField walls;  // of a level frame at the anchor
    std::size_t used = 0;   // the search that used it last
  };
  struct Query;

  std::vector<std::size_t> candidates(const CloudTracker& tracker, const Poses& poses,
                                      double reach) const;
  Target& target(const LocalCloud& map, std::size_t number, double spacing,
                 const Eigen::Matrix3d& level);
  std::vector<SE3> starts(const Query& query, const Target& target, const Eigen::Matrix3d& level,
                          const UncertainMotion3& predicted) const;
  void look(const Query& query, const LocalCloud& map, std::size_t number, const Poses& poses,
            const Relation& relation, std::vector<CloudClosure>& closures);

  CloudClosureOptions options_;
  double next_ = 0;                        // way at which to search again [m]
  std::map<std::size_t, Target> targets_;  // by number of the local map
  std::size_t searches_ = 0;
};

}  // namespace hybrid
