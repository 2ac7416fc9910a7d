// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_place.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/core/detail/quantile.h"

namespace hybrid {
namespace {

/// Places that put the newest keyframe closer together than this are one [m], [rad]: what a drive
/// of some ten metres drifts.
constexpr double kOnePlace = 0.5;
constexpr double kOneHeading = 0.1;
/// Share of the points that lie on surfaces in the right place, where something was moved, and in a
/// wrong one that looks like it.
constexpr double kOnRight = 0.75;
constexpr double kOnWrong = 0.5;
/// Points tell of a place independently if they are so far apart along surfaces [m].
constexpr double kIndependent = 1.0;
/// Standard deviations of the start that the matches do not tell: of the drive up to them [m],
/// [rad].
constexpr double kStart = 0.1;
constexpr double kStartTurn = 0.02;
/// Searches become rarer with the way, by this share of it.
constexpr double kLater = 0.05;
/// Points of a stretch that a search uses.
constexpr int kMostPoints = 100;
/// Squares of poses that the search of one stretch in one map may score.
constexpr int kBudget = 200000;

/// Where the robot was when it saw points, roughly: most of them are near its way.
Eigen::Vector2d middle_of(const std::vector<SurfacePoint>& points) {
  std::vector<double> x, y;
  for (const SurfacePoint& point : points) {
    x.push_back(point.position.x());
    y.push_back(point.position.y());
  }
  return {median(std::move(x)), median(std::move(y))};
}

/// Those no farther from the origin.
std::vector<SurfacePoint> within(double distance, std::vector<SurfacePoint> points) {
  const auto is_far = [&](const SurfacePoint& p) { return p.position.norm() > distance; };
  points.erase(std::remove_if(points.begin(), points.end(), is_far), points.end());
  return points;
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
  for (const StoredScans& scans : stored_) targets_.push_back(surroundings(scans));
}

/// All that stored scans tell of what can be seen from the way of one of them, in its frame.
std::shared_ptr<const MatchTarget> ScanPlaceSearch::surroundings(const StoredScans& scans) const {
  const Eigen::Vector2d middle = middle_of(scans.points);
  std::vector<SurfacePoint> points;
  for (const StoredScans& other : stored_) {
    const SE2 T = scans.T_map_anchor.between(other.T_map_anchor);
    for (const SurfacePoint& point : transformed(T, other.points)) {
      const double far = (point.position - middle).cwiseAbs().maxCoeff();
      if (far < options_.reach + options_.view) points.push_back(point);
    }
  }
  return std::make_shared<const MatchTarget>(make_match_target(points));
}

/// Counts a match for the place that it agrees with, or for a new one. Of several matches of one
/// stretch, with stored scans that overlap, the best counts.
void ScanPlaceSearch::vote(const UncertainMotion& T_map_drive, const SE2& stretch, double way,
                           double log_odds) {
  const SE2 here = T_map_drive.motion * stretch;
  for (Place& place : places_) {
    if (!is_one_place(place.T_map_drive.motion * stretch, here)) continue;
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
    place.stretch = stretch;
    return;
  }
  places_.push_back({T_map_drive, stretch, 1, log_odds, way, log_odds});
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

std::vector<ScanPlaceSearch::Place> ScanPlaceSearch::places() const {
  std::vector<Place> out = places_;
  std::stable_sort(out.begin(), out.end(),
                   [](const Place& a, const Place& b) { return a.log_odds > b.log_odds; });
  return out;
}

const ScanPlaceSearch::Place* ScanPlaceSearch::look(const std::vector<SurfacePoint>& points,
                                                    const SE2& stretch, double way) {
  const std::vector<SurfacePoint> query = within(options_.view, points);
  if (query.empty()) return nullptr;
  MatchOptions options;
  options.min_inliers = options_.min_inliers;
  options.most_points = kMostPoints;
  options.search.budget = kBudget;
  for (std::size_t m = 0; m < stored_.size(); ++m) {
    const Eigen::Vector2d middle = middle_of(stored_[m].points);
    const SearchWindow window{SE2(middle.x(), middle.y(), 0.0),
                              Eigen::Vector2d::Constant(options_.reach), M_PI};
    for (const MatchMode& mode : match(query, *targets_[m], window, options)) {
      const SE2 T_map_stretch = stored_[m].T_map_anchor * mode.pose.motion;
      const Eigen::Matrix3d Ad = mode.pose.motion.inverse().adjoint();
      const Eigen::Matrix3d Ad_drive = stretch.adjoint();
      const Eigen::Matrix3d at_stretch =
          mode.pose.covariance + Ad * stored_[m].covariance * Ad.transpose();
      vote({T_map_stretch * stretch.inverse(), Ad_drive * at_stretch * Ad_drive.transpose()},
           stretch, way, log_odds_of(query, mode.inliers));
    }
  }
  return best();
}

std::optional<UncertainMotion> ScanPlaceSearch::look(const ScanMapper& mapper) {
  const ScanTracker& tracker = mapper.tracker();
  if (tracker.keyframes().empty()) return std::nullopt;
  const double way = tracker.keyframes().back().travelled;
  if (way < next_) return std::nullopt;
  next_ = way + std::max(options_.every, kLater * way);
  const SE2 newest = mapper.pose(tracker.keyframes().size() - 1);
  const Place* found = look(recent_points(tracker, options_.query_length), newest, way);
  if (found == nullptr) return std::nullopt;
  UncertainMotion start{found->T_map_drive.motion * mapper.pose(0), found->T_map_drive.covariance};
  start.covariance.diagonal() += Eigen::Vector3d(kStart, kStart, kStartTurn).cwiseAbs2();
  return start;
}

}  // namespace hybrid
