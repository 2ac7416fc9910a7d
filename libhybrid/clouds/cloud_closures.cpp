// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_closures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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

/// Adds what one place gives, all modes of which belong together.
void add_place(std::vector<CloudClosure> modes, std::vector<CloudClosure>& closures) {
  const std::size_t first = closures.size();
  for (CloudClosure& mode : modes) {
    mode.modes = static_cast<int>(modes.size());
    mode.first_mode = first;
    closures.push_back(mode);
  }
}

}  // namespace

/// What is seen at the end of the path, in the frame of the newest cloud.
struct CloudClosureSearch::Query {
  const std::vector<LocalCloud>& maps;
  std::size_t cloud = 0;
  double spacing = 0, reach = 0;
  std::vector<CloudPoint> points = {};
  double way = 0;                  // along which they were seen [m]
  double shared = 1;               // number of searches that share them
  Matrix6 walk = Matrix6::Zero();  // covariance of the motion along it

  CloudClosure closure(const CloudAlignment& mode, double from_anchor) const;
};

/// The places of a stretch walk at random relative to its end, and so does their mean, by a third
/// of that; the same holds for the map around the cloud to which a closure refers, or from the
/// anchor of a stored cloud to the place. Searches that share points tell a share each.
CloudClosure CloudClosureSearch::Query::closure(const CloudAlignment& mode,
                                                double from_anchor) const {
  const double steps = 2.0 / 3.0 + (way > 0 ? from_anchor / way : 0.0);
  CloudClosure out;
  out.to = cloud;
  out.pose = {mode.pose, shared * (alignment_covariance(mode) + steps * walk)};
  out.inliers = mode.inliers;
  return out;
}

CloudClosureSearch::CloudClosureSearch(const CloudClosureOptions& options) : options_(options) {
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
        transformed(stored.T_map_anchor.motion, chosen(stored.points, kSamplePoints)));
  }
}

/// Complete local maps that were left behind, nearest first.
std::vector<CloudClosureSearch::TargetName> CloudClosureSearch::candidates(
    const CloudTracker& tracker, const Poses& poses) const {
  const std::vector<LocalCloud>& maps = tracker.local_maps();
  const Eigen::Vector3d here = poses(tracker.clouds() - 1).translation();
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t m = 0; m + 1 < maps.size(); ++m) {
    const LocalCloud& map = maps[m];
    if (map.anchor + map.poses.size() > maps.back().anchor || map.points.empty()) continue;
    const SE3 anchor = poses(map.anchor);
    double nearest = std::numeric_limits<double>::infinity();
    for (const SE3& pose : map.poses) {
      nearest = std::min(nearest, (anchor * pose.translation() - here).norm());
    }
    if (nearest < (options_.view + options_.max_reach) * tracker.reach()) {
      near.emplace_back(nearest, m);
    }
  }
  std::stable_sort(near.begin(), near.end());
  std::vector<TargetName> out;
  for (const auto& [distance, m] : near) {
    const bool overlaps = std::any_of(out.begin(), out.end(), [m = m](const TargetName& other) {
      return other.number + 1 == m || m + 1 == other.number;
    });
    if (!overlaps && static_cast<int>(out.size()) < options_.most_maps) out.push_back({false, m});
  }
  return out;
}

/// Stored clouds that may be seen from a place, nearest first.
std::vector<CloudClosureSearch::TargetName> CloudClosureSearch::stored_candidates(
    const Eigen::Vector3d& here, double reach) const {
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t m = 0; m < samples_.size(); ++m) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const CloudPoint& point : samples_[m]) {
      nearest = std::min(nearest, (point.position.cast<double>() - here).norm());
    }
    if (nearest < (options_.view + options_.max_reach) * reach) near.emplace_back(nearest, m);
  }
  std::stable_sort(near.begin(), near.end());
  std::vector<TargetName> out;
  for (const auto& [distance, m] : near) {
    if (static_cast<int>(out.size()) < options_.most_maps) out.push_back({true, m});
  }
  return out;
}

/// Made when first needed, and kept as long as it is among those used last.
const CloudTarget& CloudClosureSearch::target(const TargetName& name,
                                              const std::vector<CloudPoint>& points, double spacing,
                                              const SE3& T_map_anchor) {
  auto found = targets_.find(name);
  if (found == targets_.end()) {
    found = targets_.emplace(name, KeptTarget{make_cloud_target(points, spacing, T_map_anchor), 0})
                .first;
  }
  found->second.used = ++searches_;
  if (targets_.size() > kMostTargets) {
    targets_.erase(std::min_element(
        targets_.begin(), targets_.end(),
        [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
  }
  return found->second.target;
}

CloudMatchOptions CloudClosureSearch::match_options(double reach) const {
  return {options_.max_reach * reach, options_.max_turn, options_.min_inliers,
          options_.most_points};
}

/// `predicted` is the pose of the newest cloud in the frame of the anchor.
std::vector<CloudClosure> CloudClosureSearch::look_at_local_map(const Query& query, std::size_t m,
                                                                const Poses& poses,
                                                                const UncertainMotion3& predicted) {
  const LocalCloud& map = query.maps[m];
  const CloudTarget& target =
      this->target({false, m}, map.points, query.spacing, poses(map.anchor));
  std::vector<CloudClosure> found;
  for (const CloudAlignment& mode :
       match(query.points, target, predicted, match_options(query.reach))) {
    // What lies between the anchor and the nearest cloud is not known as well as the match is.
    const auto nearest =
        std::min_element(map.poses.begin(), map.poses.end(), [&](const SE3& a, const SE3& b) {
          return (a.translation() - mode.pose.translation()).norm() <
                 (b.translation() - mode.pose.translation()).norm();
        });
    CloudClosure out = query.closure(mode, 0);
    out.from = map.anchor + static_cast<std::size_t>(nearest - map.poses.begin());
    out.pose.motion = nearest->between(mode.pose);
    found.push_back(out);
  }
  return found;
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
std::vector<CloudClosure> CloudClosureSearch::try_proposed(const Query& query,
                                                           const ProposedClosure& proposed,
                                                           std::size_t m, const Poses& poses,
                                                           const Relation& relation,
                                                           std::vector<SE3>& seen) {
  const LocalCloud& map = query.maps[m];
  Matrix6 covariance = Matrix6::Identity();
  covariance.topLeftCorner<3, 3>() *= std::pow(kProposedSpacings * query.spacing, 2);
  covariance.bottomRightCorner<3, 3>() *= kProposedAngle * kProposedAngle;
  const SE3& from = map.poses[proposed.from - map.anchor];
  std::vector<CloudClosure> found =
      look_at_local_map(query, m, poses, {from * proposed.pose, covariance});
  std::vector<CloudClosure> added;
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
    added.push_back(closure);
    seen.push_back(pose);
  }
  ++(found.empty() ? count_.unmatched : added.empty() ? count_.same : count_.matched);
  return added;
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
    if (!query) query.emplace(present_query(tracker, relation));
    add_place(try_proposed(*query, *it, *m, poses, relation, seen[*m]), closures);
  }
}

std::vector<CloudClosure> CloudClosureSearch::look_at_stored(const Query& query,
                                                             const TargetName& name,
                                                             const UncertainMotion3& predicted) {
  const StoredCloud& stored = stored_[name.number];
  const CloudTarget& target =
      this->target(name, stored.points, query.spacing, stored.T_map_anchor.motion);
  std::vector<CloudClosure> found;
  for (const CloudAlignment& mode :
       match(query.points, target, predicted, match_options(query.reach))) {
    CloudClosure out = query.closure(mode, mode.pose.translation().norm());
    out.from = name.number;
    out.is_known = true;
    found.push_back(out);
  }
  return found;
}

/// What the present local map shows, and how it is known beside a match.
CloudClosureSearch::Query CloudClosureSearch::present_query(const CloudTracker& tracker,
                                                            const Relation& relation) const {
  Query query{tracker.local_maps()};
  const LocalCloud& present = query.maps.back();
  query.cloud = tracker.clouds() - 1;
  query.spacing = tracker.surfaces()->spacing();
  query.reach = tracker.reach();
  query.points = chosen(transformed(present.poses.back().inverse(), tracker.surfaces()->points()),
                        options_.most_points);
  query.way = present.travelled.back() - present.travelled.front();
  query.shared = std::max(1.0, query.way / (options_.every * query.reach));
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
  const std::vector<TargetName> near = candidates(tracker, poses);
  const std::vector<TargetName> near_stored =
      stored_candidates(poses(tracker.clouds() - 1).translation(), tracker.reach());
  if (near.empty() && near_stored.empty()) return closures;
  const Query query = present_query(tracker, relation);
  for (const TargetName& name : near) {
    const UncertainMotion3 predicted = relation(query.maps[name.number].anchor, query.cloud);
    add_place(look_at_local_map(query, name.number, poses, predicted), closures);
  }
  for (const TargetName& name : near_stored) {
    add_place(look_at_stored(query, name, stored(name.number, query.cloud)), closures);
  }
  return closures;
}

}  // namespace hybrid
