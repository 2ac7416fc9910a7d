// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/scans/scan_join.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/online/online_selection.h"

namespace hybrid {
namespace {

/// Points of stored scans are so far apart [m].
constexpr double kStoredSpacing = 0.1;
/// Matches that must agree with each other, for two maps to be joined.
constexpr std::size_t kLeastMatches = 3;
/// Stretches of a map that are searched in the other, at most.
constexpr std::size_t kMostStretches = 60;
/// Standard deviations of the motion between two maps about a place that was found, of which else
/// nothing is known [m], [rad].
constexpr double kPlaceSigma = 0.5;
constexpr double kPlaceTurn = 0.1;
/// Smallest standard deviation of a local map, such as of one that defines the frame [m, rad].
constexpr double kLeastOfLocalMap = 1e-4;

/// Of the frame of the second map in that of the first.
const Key kMotion(key_letter::kPose, 0);

Key key_of_first(std::size_t i) {
  return {key_letter::kPose, (std::size_t{1} << 30) + i};
}

Key key_of_second(std::size_t k) {
  return {key_letter::kPose, k + 1};
}

Noise noise_of(const Eigen::Matrix3d& covariance) {
  return Noise::covariance(covariance +
                           kLeastOfLocalMap * kLeastOfLocalMap * Eigen::Matrix3d::Identity());
}

Eigen::Vector2d mean_of(const std::vector<SurfacePoint>& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const SurfacePoint& point : points) sum += point.position;
  return sum / double(std::max<std::size_t>(points.size(), 1));
}

std::string number(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string text_of(const ScanPlace& place) {
  const SE2 at = place.T_map_drive.motion * place.stretch;
  return "(" + number("%.1f", at.x()) + " " + number("%.1f", at.y()) + ") with " +
         number("%.0f", 100 * place.on / std::max(1e-9, place.on + place.off)) +
         " % of their surfaces";
}

/// What speaks against the best of places that do not stand out.
std::string doubt_of(const ScanPlaceSearch& search, const ScanPlaceOptions& options) {
  const std::vector<ScanPlace>& places = search.places();
  if (places.empty()) return "no stretch of its laser scans fits those of the other map";
  const ScanPlace& best = places.front();
  if (static_cast<int>(best.seen_from.size()) < options.votes) {
    return "the place that fits its laser scans best, " + text_of(best) + ", has " +
           std::to_string(best.seen_from.size()) + " of the " + std::to_string(options.votes) +
           " stretches that must agree";
  }
  if (places.size() > 1 && best.fit - places[1].fit <= std::log(options.odds)) {
    return "its laser scans fit at " + text_of(best) + ", and as well at " + text_of(places[1]);
  }
  return "its laser scans may fit by chance at " + text_of(best) + ", log odds " +
         number("%.1f", search.log_odds()) + " of " + number("%.1f", std::log(options.odds)) +
         " that are needed";
}

/// Local maps of two maps, the motion between these, and matches, some of which may be false.
class ScanJoinGraph {
 public:
  ScanJoinGraph(const std::vector<StoredScans>& first, const std::vector<StoredScans>& second,
                const ScanPlace& place)
      : first_(first), second_(second), targets_(first.size()) {
    // What is known of the motion is known at the place, not at the origin of the second map.
    const Eigen::Matrix3d Ad = place.stretch.adjoint();
    const Eigen::Matrix3d at_place =
        Eigen::Vector3d(kPlaceSigma, kPlaceSigma, kPlaceTurn).cwiseAbs2().asDiagonal();
    insert(kMotion, place.T_map_drive.motion,
           std::make_shared<Prior<SE2>>(kMotion, place.T_map_drive.motion,
                                        Noise::covariance(Ad * at_place * Ad.transpose())));
    for (const std::size_t k : nearest_to(place.stretch.translation())) add(k);
    selection_.finish();
  }

  std::size_t matches() const { return matches_; }
  std::size_t accepted() const {
    std::size_t count = 0;
    for (std::size_t c = 0; c < matches_; ++c) {
      if (selection_.status(c) == ClosureStatus::kAccepted) ++count;
    }
    return count;
  }
  UncertainMotion motion() const { return {pose(kMotion), covariance(kMotion)}; }
  std::vector<StoredScans> first() const {
    std::vector<StoredScans> out = first_;
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (holds(key_of_first(i))) place(key_of_first(i), out[i]);
    }
    return out;
  }
  std::vector<StoredScans> second() const {
    std::vector<StoredScans> out = second_;
    for (std::size_t k = 0; k < out.size(); ++k) place(key_of_second(k), out[k]);
    return out;
  }

 private:
  SE2 pose(Key key) const { return selection_.smoother().values().at<SE2>(key); }
  Eigen::Matrix3d covariance(Key key) const {
    return selection_.smoother().joint_covariance({key},
                                                  Eigen::MatrixXd(Eigen::Matrix3d::Identity()));
  }
  bool holds(Key key) const { return selection_.smoother().values().contains(key); }
  void place(Key key, StoredScans& scans) const {
    scans.T_map_anchor = pose(key);
    scans.covariance = covariance(key);
  }
  void insert(Key key, const SE2& pose, ContinuousFactorPtr factor) {
    Delta delta;
    delta.values.insert(key, pose);
    delta.continuous.push_back(std::move(factor));
    selection_.update(delta);
  }

  /// The local maps of the second map, those near a place in its frame first.
  std::vector<std::size_t> nearest_to(const Eigen::Vector2d& at) const {
    std::vector<std::size_t> order(second_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return (second_[a].T_map_anchor.translation() - at).norm() <
             (second_[b].T_map_anchor.translation() - at).norm();
    });
    return order;
  }

  /// Local maps of the first map that may show what one of the second saw, the nearest ones.
  std::vector<std::size_t> near(const SE2& pose, const StoredScans& scans) const {
    const Eigen::Vector2d middle = pose * mean_of(scans.points);
    std::vector<std::pair<double, std::size_t>> all;
    for (std::size_t i = 0; i < first_.size(); ++i) {
      const Eigen::Vector2d of_first = first_[i].T_map_anchor * mean_of(first_[i].points);
      const double distance = (of_first - middle).norm();
      if (distance < options_.view + options_.max_reach) all.emplace_back(distance, i);
    }
    std::sort(all.begin(), all.end());
    std::vector<std::size_t> out;
    for (const auto& [distance, i] : all) {
      if (static_cast<int>(out.size()) < options_.most_maps) out.push_back(i);
    }
    return out;
  }

  /// Where a local map of the second is in one of the first, as known so far.
  UncertainMotion relation(std::size_t i, std::size_t k) const {
    const Key key = key_of_second(k);
    if (holds(key_of_first(i))) return relation_of(key_of_first(i), key, selection_.smoother());
    const SE2 motion = first_[i].T_map_anchor.between(pose(key));
    const Eigen::Matrix3d Ad = motion.inverse().adjoint();
    return {motion, covariance(key) + Ad * first_[i].covariance * Ad.transpose()};
  }

  /// Adds a local map of the second map, and its matches.
  void add(std::size_t k) {
    const StoredScans& scans = second_[k];
    const Key key = key_of_second(k);
    insert(
        key, pose(kMotion) * scans.T_map_anchor,
        std::make_shared<BetweenSE2>(kMotion, key, scans.T_map_anchor, noise_of(scans.covariance)));
    if (scans.points.empty()) return;
    std::vector<ContinuousFactorPtr> found;
    Alternatives modes;
    for (const std::size_t i : near(pose(key), scans)) {
      const SearchWindow window = window_of(relation(i, k), options_);
      if (!targets_[i]) targets_[i] = make_match_target(first_[i].points);
      const std::size_t first_mode = found.size();
      for (const MatchMode& mode : match(scans.points, *targets_[i], window, options_.match)) {
        if (!holds(key_of_first(i))) {
          insert(key_of_first(i), first_[i].T_map_anchor,
                 std::make_shared<Prior<SE2>>(key_of_first(i), first_[i].T_map_anchor,
                                              noise_of(first_[i].covariance)));
        }
        modes.add(first_mode);
        found.push_back(std::make_shared<BetweenSE2>(key_of_first(i), key, mode.pose.motion,
                                                     Noise::covariance(mode.pose.covariance)));
      }
    }
    matches_ += found.size();
    if (!found.empty()) selection_.update({}, found, modes);
  }

  const std::vector<StoredScans>&first_, &second_;
  ScanClosureOptions options_;
  std::vector<std::optional<MatchTarget>> targets_;  // of the first map, as they are needed
  OnlineSelection selection_;
  std::size_t matches_ = 0;
};

}  // namespace

std::vector<StoredScans> stored_scans(const MapRecord& map) {
  std::vector<StoredScans> out;
  for (const MapLocalMap& local : map.local_maps) {
    StoredScans scans;
    scans.T_map_anchor = SE2(local.pose.x(), local.pose.y(), local.pose.z());
    scans.covariance = local.covariance;
    for (const MapSurface& surface : local.surfaces) {
      SurfacePoint point;
      point.position = surface.position;
      if (surface.direction) {
        point.normal << std::cos(*surface.direction), std::sin(*surface.direction);
      }
      point.length = kStoredSpacing;
      scans.points.push_back(point);
    }
    out.push_back(std::move(scans));
  }
  return out;
}

ScanJoin join_scans(const std::vector<StoredScans>& first, const std::vector<StoredScans>& second,
                    const ScanPlaceOptions& options) {
  ScanJoin out;
  ScanPlaceSearch search(first, options);
  const ScanPlace* found = nullptr;
  // Of local maps that overlap, every second one: what a surface says counts once.
  const std::size_t step = std::max<std::size_t>(2, second.size() / kMostStretches);
  for (std::size_t k = 0; k < second.size() && found == nullptr; k += step) {
    const SE2 T_anchor_middle(mean_of(second[k].points), SO2());
    found = search.look(transformed(T_anchor_middle.inverse(), second[k].points),
                        second[k].T_map_anchor * T_anchor_middle);
  }
  if (found == nullptr) {
    out.why = doubt_of(search, options);
    return out;
  }
  const ScanJoinGraph graph(first, second, *found);
  out.matches = graph.matches();
  out.accepted = graph.accepted();
  out.log_odds = search.log_odds();
  if (out.accepted < kLeastMatches) {
    out.why = "its laser scans fit at " + text_of(*found) + ", but of " +
              std::to_string(out.matches) + " matches there only " + std::to_string(out.accepted) +
              " agree with each other";
    return out;
  }
  out.T_first_second = graph.motion();
  out.first = graph.first();
  out.second = graph.second();
  return out;
}

std::optional<JoinedMaps> join_maps_by_scans(const MapRecord& first, const MapRecord& second,
                                             double odds, std::string& why) {
  refuse_to_join(first, second);
  if (first.is_3d || first.local_maps.empty() || second.local_maps.empty()) {
    why = "there are no laser scans in the plane in both to find a common place by";
    return std::nullopt;
  }
  ScanPlaceOptions options;
  options.odds = odds;
  const ScanJoin join = join_scans(stored_scans(first), stored_scans(second), options);
  why = join.why;
  if (!join.is_found()) return std::nullopt;
  JoinedMaps out = join_maps_at(first, second, to_isometry(join.T_first_second.motion),
                                join.T_first_second.covariance);
  out.scan_matches = join.accepted;
  out.log_odds = join.log_odds;
  std::vector<StoredScans> all = join.first;
  all.insert(all.end(), join.second.begin(), join.second.end());
  for (std::size_t m = 0; m < all.size(); ++m) {
    const SE2& pose = all[m].T_map_anchor;
    out.map.local_maps[m].pose << pose.x(), pose.y(), pose.angle();
    out.map.local_maps[m].covariance = all[m].covariance;
  }
  return out;
}

}  // namespace hybrid
