// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_place.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hybrid {
namespace {

/// Places that put the newest keyframe closer together than this are one [m], [rad]: what a drive
/// of some ten metres drifts.
constexpr double kOnePlace = 0.5;
constexpr double kOneHeading = 0.1;
/// Share of the points that lie on surfaces in the right place, where something was moved, and in a
/// wrong one that looks like it.
constexpr double kOnRight = 0.95;
constexpr double kOnWrong = 0.6;
/// Points tell of a place independently if they are so far apart along surfaces [m].
constexpr double kIndependent = 1.0;
/// Standard deviations of the start that the matches do not tell: of the drive up to them [m],
/// [rad].
constexpr double kStart = 0.1;
constexpr double kStartTurn = 0.02;
/// Nodes that the search of one stretch in one map may score.
constexpr int kBudget = 400000;

/// The box around the points: its middle, and half its size.
std::pair<Eigen::Vector2d, Eigen::Vector2d> box_of(const std::vector<SurfacePoint>& points) {
  Eigen::Array2d low = points.front().position.array(), high = low;
  for (const SurfacePoint& point : points) {
    low = low.min(point.position.array());
    high = high.max(point.position.array());
  }
  return {(0.5 * (low + high)).matrix(), (0.5 * (high - low)).matrix()};
}

/// Of the right place to a wrong one, by the share of points that lie on surfaces.
double log_odds_of(const std::vector<SurfacePoint>& points, double inliers) {
  double length = 0.0;
  for (const SurfacePoint& point : points) length += std::min(point.length, kIndependent);
  return length / kIndependent *
         (inliers * std::log(kOnRight / kOnWrong) +
          (1.0 - inliers) * std::log((1.0 - kOnRight) / (1.0 - kOnWrong)));
}

bool is_one_place(const SE2& a, const SE2& b) {
  const SE2 off = a.between(b);
  return off.translation().norm() < kOnePlace && std::abs(off.angle()) < kOneHeading;
}

}  // namespace

ScanPlaceSearch::ScanPlaceSearch(std::vector<StoredScans> stored, const ScanPlaceOptions& options)
    : options_(options), stored_(std::move(stored)), next_(options.query_length) {
  const auto is_empty = [](const StoredScans& scans) { return scans.points.empty(); };
  stored_.erase(std::remove_if(stored_.begin(), stored_.end(), is_empty), stored_.end());
  for (const StoredScans& scans : stored_) {
    targets_.push_back(std::make_shared<const MatchTarget>(make_match_target(scans.points)));
  }
}

/// Counts a match for the place that it agrees with, or for a new one. Of several matches of one
/// stretch, with stored scans that overlap, the best counts.
void ScanPlaceSearch::vote(const UncertainMotion& T_map_drive, const SE2& newest, double way,
                           double log_odds) {
  const SE2 here = T_map_drive.motion * newest;
  for (Place& place : places_) {
    if (!is_one_place(place.T_map_drive.motion * newest, here)) continue;
    if (place.last_vote == way) {
      if (log_odds <= place.last_odds) return;
      place.log_odds -= place.last_odds;
      --place.votes;
    }
    ++place.votes;
    place.log_odds += log_odds;
    place.last_vote = way;
    place.last_odds = log_odds;
    place.T_map_drive = T_map_drive;
    return;
  }
  places_.push_back({T_map_drive, 1, log_odds, way, log_odds});
}

/// The place that stands out, if one does.
const ScanPlaceSearch::Place* ScanPlaceSearch::best() const {
  const Place* best = nullptr;
  double other = 0.0;  // that it is chance
  for (const Place& place : places_) {
    if (best == nullptr || place.log_odds > best->log_odds) {
      if (best != nullptr) other = std::max(other, best->log_odds);
      best = &place;
    } else {
      other = std::max(other, place.log_odds);
    }
  }
  const bool stands_out = best != nullptr && best->votes >= options_.votes &&
                          best->log_odds - other > std::log(options_.odds);
  return stands_out ? best : nullptr;
}

std::optional<UncertainMotion> ScanPlaceSearch::look(const ScanMapper& mapper) {
  const ScanTracker& tracker = mapper.tracker();
  if (tracker.keyframes().empty()) return std::nullopt;
  const double way = tracker.keyframes().back().travelled;
  if (way < next_) return std::nullopt;
  next_ = way + options_.every;
  const SE2 newest = mapper.pose(tracker.keyframes().size() - 1);
  const std::vector<SurfacePoint> query = recent_points(tracker, options_.query_length);
  if (query.empty()) return std::nullopt;
  MatchOptions options;
  options.min_inliers = options_.min_inliers;
  options.search.budget = kBudget;
  for (std::size_t m = 0; m < stored_.size(); ++m) {
    const auto [middle, half] = box_of(stored_[m].points);
    const SearchWindow window{SE2(middle.x(), middle.y(), 0.0), half.cwiseMin(options_.most_reach),
                              M_PI};
    for (const MatchMode& mode : match(query, *targets_[m], window, options)) {
      const SE2 T_map_newest = stored_[m].T_map_anchor * mode.pose.motion;
      const Eigen::Matrix3d Ad = mode.pose.motion.inverse().adjoint();
      const Eigen::Matrix3d Ad_first = newest.adjoint();
      const Eigen::Matrix3d at_newest =
          mode.pose.covariance + Ad * stored_[m].covariance * Ad.transpose();
      vote({T_map_newest * newest.inverse(), Ad_first * at_newest * Ad_first.transpose()}, newest,
           way, log_odds_of(query, mode.inliers));
    }
  }
  const Place* found = best();
  if (found == nullptr) return std::nullopt;
  UncertainMotion start{found->T_map_drive.motion * mapper.pose(0), found->T_map_drive.covariance};
  start.covariance.diagonal() += Eigen::Vector3d(kStart, kStart, kStartTurn).cwiseAbs2();
  return start;
}

}  // namespace hybrid
