// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "libhybrid/clouds/cloud_match.h"
#include "libhybrid/clouds/cloud_tracker.h"
#include "libhybrid/online/place_search.h"

namespace HYBRID_API hybrid {

/// A closure that others have found, to be tried from its pose.
struct ProposedClosure {
  std::size_t from = 0, to = 0;  ///< clouds; the second one is later
  SE3 pose;                      ///< of `to` in the frame of `from`
};

/// Lengths are shares of the reach of the sensor, see reach_of().
struct CloudClosureOptions {
  double every = 0.5;                     ///< way between searches
  double view = 1;                        ///< distance at which places share surfaces
  double max_reach = 2;                   ///< half the width of the window of a search, at most
  double max_turn = 0.8;                  ///< and of its angle about the vertical, at most [rad]
  int most_maps = 4;                      ///< local maps searched for one cloud, at most
  double min_inliers = 0.5;               ///< modes of a smaller share are left out
  std::size_t most_points = 2000;         ///< that are matched, evenly chosen
  std::vector<ProposedClosure> proposed;  ///< in any order; of each pair the first one counts
};

/// What became of closures that others have found. A pair of clouds counts once.
struct ProposedCount {
  std::size_t matched = 0;    ///< tried, and found
  std::size_t unmatched = 0;  ///< tried: too few points lie on surfaces at any pose near it
  std::size_t same = 0;       ///< tried: its pose is that which another pair has led to
  std::size_t near = 0;       ///< not tried: one local map has both, or two that overlap
  std::size_t blind = 0;      ///< not tried: no surface was seen at one of them
  std::size_t repeated = 0;   ///< not tried: the pair was proposed before
  std::size_t absent = 0;     ///< not tried: of clouds that did not come
};

/// A relative pose between clouds of different times, or of a stored cloud and a cloud.
using CloudClosure = PlaceClosure<SE3>;

/// What clouds saw along a stretch of an earlier drive, in the frame of its first cloud.
struct StoredCloud {
  KnownPlace<SE3> T_map_anchor;
  std::vector<CloudPoint> points;
  double spacing = 0;  ///< between these [m]
};

/// Searches earlier local maps, and clouds of earlier drives, for the place of the newest cloud.
/// Maps of walls and poles, seen from above, tell all poses in the plane at which these may lie on
/// each other; from each, and from the pose that the path predicts, the surfaces are aligned in
/// space.
class CloudClosureSearch {
 public:
  /// Estimate of the pose of a cloud.
  using Poses = std::function<SE3(std::size_t cloud)>;
  /// Estimate of the pose of cloud b in the frame of a.
  using Relation = std::function<UncertainMotion3(std::size_t a, std::size_t b)>;

  explicit CloudClosureSearch(const CloudClosureOptions& options = {});

  /// Clouds of earlier drives to search, too, in the frame of the estimates.
  void store(std::vector<StoredCloud> clouds);
  const std::vector<StoredCloud>& stored() const { return stored_; }

  /// All modes of each place; none while the way since the last search is short and nothing is
  /// proposed. What is proposed has the clouds that it was proposed for. `stored` tells the pose of
  /// a cloud b in the frame of the stored cloud a.
  std::vector<CloudClosure> search(const CloudTracker& tracker, const Poses& poses,
                                   const Relation& relation, const Relation& stored = {});
  /// Of those that were proposed, after so many clouds.
  ProposedCount proposed(std::size_t clouds) const;

 private:
  struct Query;

  std::vector<std::size_t> candidates(const CloudTracker& tracker, const Poses& poses) const;
  std::vector<std::size_t> stored_candidates(const Eigen::Vector3d& here, double reach) const;
  Query present_query(const CloudTracker& tracker, const Relation& relation) const;
  void look(const Query& query, const PlaceName& name, const SE3& T_map_anchor,
            const UncertainMotion3& predicted, std::vector<CloudClosure>& closures);
  void look_at_proposed(const CloudTracker& tracker, const Poses& poses, const Relation& relation,
                        std::vector<CloudClosure>& closures);
  void try_proposed(const Query& query, const ProposedClosure& proposed, std::size_t map,
                    const Poses& poses, const Relation& relation, std::vector<SE3>& seen,
                    std::vector<CloudClosure>& closures);
  std::optional<std::size_t> map_of_proposed(std::size_t cloud, const CloudTracker& tracker);

  CloudClosureOptions options_;
  ProposedCount count_;  // but for absent ones
  double next_ = 0;      // way at which to search again [m]
  KeptTargets<CloudTarget> targets_;
  std::vector<StoredCloud> stored_;
  std::vector<std::vector<CloudPoint>> samples_;  // of each of these, in the map
};

}  // namespace hybrid
