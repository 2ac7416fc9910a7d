// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_closures.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "libhybrid/core/evenly_chosen.h"

namespace hybrid {
namespace {

/// Targets kept in memory; others are made again when needed.
constexpr std::size_t kMostTargets = 20;
/// Points of a stored cloud that tell how far it is.
constexpr std::size_t kSamplePoints = 200;
/// Standard deviations of closures that others have found [spacings], [rad].
constexpr double kProposedSpacings = 5;
constexpr double kProposedAngle = 0.1;

struct ByCloud {
  bool operator()(const ProposedClosure& a, const ProposedClosure& b) const { return a.to < b.to; }
};

/// Those to a cloud, of sorted ones.
auto proposed_to(std::size_t cloud, const std::vector<ProposedClosure>& all) {
  return std::equal_range(all.begin(), all.end(), ProposedClosure{0, cloud, {}}, ByCloud());
}

}  // namespace

/// What is seen at the end of the path, in the frame of the newest cloud.
struct CloudClosureSearch::Query : PathEnd<SE3> {
  const CloudTracker* tracker = nullptr;
  std::size_t cloud = 0;
  double spacing = 0;
  std::vector<CloudPoint> points;
};

CloudClosureSearch::CloudClosureSearch(const CloudClosureOptions& options)
    : options_(options), targets_(kMostTargets) {
  std::vector<ProposedClosure>& all = options_.proposed;
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return std::make_pair(a.to, a.from) < std::make_pair(b.to, b.from);
  });
  const auto end = std::unique(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.to == b.to && a.from == b.from;
  });
  count_.repeated = static_cast<std::size_t>(all.end() - end);
  all.erase(end, all.end());
}

ProposedCount CloudClosureSearch::proposed(std::size_t clouds) const {
  ProposedCount out = count_;
  for (const ProposedClosure& proposed : options_.proposed) out.absent += proposed.to >= clouds;
  return out;
}

void CloudClosureSearch::store(std::vector<StoredCloud> clouds) {
  stored_ = std::move(clouds);
  samples_.clear();
  for (const StoredCloud& stored : stored_) {
    samples_.push_back(
        transformed(stored.T_map_anchor.motion, evenly_chosen(stored.points, kSamplePoints)));
  }
}

/// Complete local maps that were left behind, nearest first.
std::vector<std::size_t> CloudClosureSearch::candidates(const CloudTracker& tracker,
                                                        const Poses& poses) const {
  const Eigen::Vector3d here = poses(tracker.clouds() - 1).translation();
  const double limit = (options_.view + options_.max_reach) * tracker.reach();
  std::vector<std::size_t> out;
  for (const auto& [distance, m] : maps_near(tracker.local_maps(), poses, here, limit)) {
    if (tracker.local_maps()[m].points.empty() || overlaps(out, m)) continue;
    if (static_cast<int>(out.size()) < options_.most_maps) out.push_back(m);
  }
  return out;
}

/// Stored clouds that may be seen from a place, nearest first.
std::vector<std::size_t> CloudClosureSearch::stored_candidates(const Eigen::Vector3d& here,
                                                               double reach) const {
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t m = 0; m < samples_.size(); ++m) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const CloudPoint& point : samples_[m]) {
      nearest = std::min(nearest, (point.position.cast<double>() - here).norm());
    }
    if (nearest < (options_.view + options_.max_reach) * reach) near.emplace_back(nearest, m);
  }
  std::stable_sort(near.begin(), near.end());
  std::vector<std::size_t> out;
  for (const auto& [distance, m] : near) {
    if (static_cast<int>(out.size()) < options_.most_maps) out.push_back(m);
  }
  return out;
}

/// Adds all modes of the query in a local map or a stored cloud.
void CloudClosureSearch::look(const Query& query, const PlaceName& name, const SE3& T_map_anchor,
                              const UncertainMotion3& predicted,
                              std::vector<CloudClosure>& closures) {
  const LocalCloud* map = name.is_known ? nullptr : &query.tracker->local_maps()[name.number];
  const CloudTarget& target = targets_.at(name, [&] {
    return make_cloud_target(map ? map->points : stored_[name.number].points, query.spacing,
                             T_map_anchor);
  });
  const CloudMatchOptions options{options_.max_reach * query.tracker->reach(), options_.max_turn,
                                  options_.min_inliers, options_.most_points};
  const auto modes = match(query.points, target, predicted, options);
  const std::size_t first = closures.size();
  for (const CloudAlignment& mode : modes) {
    const double from_anchor = map ? 0 : mode.pose.translation().norm();
    closures.push_back({name.number,
                        query.cloud,
                        {mode.pose, query.widened(alignment_covariance(mode), from_anchor)},
                        mode.inliers,
                        static_cast<int>(modes.size()),
                        first,
                        name.is_known});
    if (map) refer_to_nearest(*map, closures.back());
  }
}

/// The complete local map that has a cloud and nothing that the present one has, too: what both
/// have seen fits itself. Counts why there is none.
std::optional<std::size_t> CloudClosureSearch::map_of_proposed(std::size_t cloud,
                                                               const CloudTracker& tracker) {
  const std::vector<LocalCloud>& maps = tracker.local_maps();
  bool is_blind = tracker.surfaces() == nullptr;
  for (std::size_t m = 0; m + 1 < maps.size() && tracker.surfaces() != nullptr; ++m) {
    const std::size_t end = maps[m].anchor + maps[m].poses.size();
    if (cloud < maps[m].anchor || cloud >= end || end > maps.back().anchor) continue;
    if (!maps[m].points.empty()) return m;
    is_blind = true;
  }
  ++(is_blind ? count_.blind : count_.near);
  return std::nullopt;
}

/// Aligns the clouds from a pose that is proposed. Its pair is that of the closures. Poses in the
/// local map that were `seen` before are left out: they were measured once.
void CloudClosureSearch::try_proposed(const Query& query, const ProposedClosure& proposed,
                                      std::size_t m, const Poses& poses, const Relation& relation,
                                      std::vector<SE3>& seen, std::vector<CloudClosure>& closures) {
  const LocalCloud& map = query.tracker->local_maps()[m];
  const SE3& from = map.poses[proposed.from - map.anchor];
  const UncertainMotion3 predicted{
      from * proposed.pose,
      isotropic_covariance(kProposedSpacings * query.spacing, kProposedAngle)};
  std::vector<CloudClosure> found;
  look(query, {false, m}, poses(map.anchor), predicted, found);
  const std::size_t first = closures.size();
  for (CloudClosure& closure : found) {
    const SE3& nearest = map.poses[closure.from - map.anchor];
    const SE3 pose = nearest * closure.pose.motion;
    const auto is_it = [&](const SE3& other) { return are_one_pose(pose, other, query.spacing); };
    if (std::any_of(seen.begin(), seen.end(), is_it)) continue;
    if (closure.from != proposed.from) {
      const Matrix6 between = relation(proposed.from, closure.from).covariance;
      closure.pose = UncertainMotion3{from.between(nearest), between} * closure.pose;
    }
    closure.from = proposed.from;
    closure.first_mode = first;
    closures.push_back(closure);
    seen.push_back(pose);
  }
  const std::size_t added = closures.size() - first;
  for (std::size_t k = first; k < closures.size(); ++k) closures[k].modes = static_cast<int>(added);
  ++(found.empty() ? count_.unmatched : added > 0 ? count_.matched : count_.same);
}

/// Tries what is proposed for the newest cloud.
void CloudClosureSearch::look_at_proposed(const CloudTracker& tracker, const Poses& poses,
                                          const Relation& relation,
                                          std::vector<CloudClosure>& closures) {
  const auto [begin, end] = proposed_to(tracker.clouds() - 1, options_.proposed);
  std::optional<Query> query;
  std::map<std::size_t, std::vector<SE3>> seen;  // by local map
  for (auto it = begin; it != end; ++it) {
    const std::optional<std::size_t> m = map_of_proposed(it->from, tracker);
    if (!m) continue;
    if (!query) query = present_query(tracker, relation);
    try_proposed(*query, *it, *m, poses, relation, seen[*m], closures);
  }
}

/// What the present local map shows, and how it is known beside a match.
CloudClosureSearch::Query CloudClosureSearch::present_query(const CloudTracker& tracker,
                                                            const Relation& relation) const {
  const LocalCloud& present = tracker.local_maps().back();
  Query query;
  query.tracker = &tracker;
  query.cloud = tracker.clouds() - 1;
  query.spacing = tracker.surfaces()->spacing();
  query.points =
      evenly_chosen(transformed(present.poses.back().inverse(), tracker.surfaces()->points()),
                    options_.most_points);
  query.way = present.travelled.back() - present.travelled.front();
  query.shared = std::max(1.0, query.way / (options_.every * tracker.reach()));
  if (present.anchor < query.cloud) {
    query.walk = relation(present.anchor, query.cloud).covariance;
  }
  return query;
}

std::vector<CloudClosure> CloudClosureSearch::search(const CloudTracker& tracker,
                                                     const Poses& poses, const Relation& relation,
                                                     const Relation& stored) {
  std::vector<CloudClosure> closures;
  look_at_proposed(tracker, poses, relation, closures);
  if (tracker.surfaces() == nullptr) return closures;
  const double way = tracker.local_maps().back().travelled.back();
  if (way < next_ || options_.most_maps == 0) return closures;
  next_ = way + options_.every * tracker.reach();
  const std::vector<std::size_t> near = candidates(tracker, poses);
  const std::vector<std::size_t> near_stored =
      stored_candidates(poses(tracker.clouds() - 1).translation(), tracker.reach());
  if (near.empty() && near_stored.empty()) return closures;
  const Query query = present_query(tracker, relation);
  for (const std::size_t m : near) {
    const std::size_t anchor = tracker.local_maps()[m].anchor;
    look(query, {false, m}, poses(anchor), relation(anchor, query.cloud), closures);
  }
  for (const std::size_t m : near_stored) {
    look(query, {true, m}, stored_[m].T_map_anchor.motion, stored(m, query.cloud), closures);
  }
  return closures;
}

}  // namespace hybrid
