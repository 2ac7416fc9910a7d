// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_place.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/core/chi_square.h"

namespace hybrid {
namespace {

/// Places that put the newest keyframe closer together than this are one [m], [rad]: what a drive
/// of some ten metres drifts.
constexpr double kOnePlace = 0.5;
constexpr double kOneHeading = 0.1;
/// Share of the surfaces that lie on those of the map in the right place, where something was
/// moved; and in a wrong one that looks like it, at least.
constexpr double kOnRight = 0.75;
constexpr double kOnWrong = 0.5;
/// One stretch in so many shows what a map lacks although its robot was near, also in the right
/// place: a room whose door was closed, the other side of things.
constexpr double kOtherView = 20.0;
/// Surfaces tell of a place independently if they are so far apart [m].
constexpr double kIndependent = 0.5;
/// Standard deviations that a place of the drive may be off from a known start: of the drive up to
/// it [m], [rad].
constexpr double kStart = 0.1;
constexpr double kStartTurn = 0.02;
/// Probability with which a known start allows the true one.
constexpr double kSureOfStart = 0.9999;
/// Searches become rarer with the way, by this share of it.
constexpr double kLater = 0.05;
/// Points of a stretch that a search uses.
constexpr int kMostPoints = 100;
/// Places that are followed, at most: a budget of time.
constexpr std::size_t kMostPlaces = 60;

/// Those no farther from the origin.
std::vector<SurfacePoint> within(double distance, std::vector<SurfacePoint> points) {
  const auto is_far = [&](const SurfacePoint& p) { return p.position.norm() > distance; };
  points.erase(std::remove_if(points.begin(), points.end(), is_far), points.end());
  return points;
}

std::vector<SurfacePoint> mirror_image(std::vector<SurfacePoint> points) {
  for (SurfacePoint& point : points) {
    point.position.y() *= -1;
    point.normal.y() *= -1;
  }
  return points;
}
SE2 mirror_image(const SE2& pose) {
  return {pose.x(), -pose.y(), -pose.angle()};
}

MatchOptions options_of_match(const ScanPlaceOptions& place) {
  MatchOptions options;
  options.min_inliers = place.min_inliers;
  options.most_points = kMostPoints;
  options.search.max_modes = 1;
  return options;
}

bool is_one_place(const SE2& a, const SE2& b) {
  const SE2 off = a.between(b);
  return off.translation().norm() < kOnePlace && std::abs(off.angle()) < kOneHeading;
}

/// What surfaces tell of a place that another, or one that the map lacks, does not share.
double fit_of(double on, double off) {
  const double sum =
      on * std::log(kOnRight / kOnWrong) + off * std::log((1.0 - kOnRight) / (1.0 - kOnWrong));
  return std::max(sum / kIndependent, -std::log(kOtherView));
}

bool is_apart(const std::vector<Eigen::Vector2d>& others, const Eigen::Vector2d& point,
              double least) {
  return std::none_of(others.begin(), others.end(),
                      [&](const Eigen::Vector2d& p) { return (p - point).norm() < least; });
}

/// Whether what is known of the start allows a place of the frame of the drive.
bool is_allowed(const std::optional<UncertainMotion>& start, const SE2& T_map_drive) {
  if (!start) return true;
  const SE2 off = start->motion.between(T_map_drive);
  const Eigen::Vector3d e(off.x(), off.y(), off.angle());
  Eigen::Matrix3d covariance = start->covariance;
  covariance.diagonal() += Eigen::Vector3d(kStart, kStart, kStartTurn).cwiseAbs2();
  return e.dot(covariance.inverse() * e) < chi_square_quantile(kSureOfStart, 3);
}

/// A match at a pose in the map with the uncertainty of the stored scans there.
UncertainMotion with_map(const PlaceTiles& tiles, const SE2& pose,
                         const Eigen::Matrix3d& covariance) {
  const std::vector<Eigen::Vector2d>& middles = tiles.middles();
  const auto distance = [&](const Eigen::Vector2d& p) { return (p - pose.translation()).norm(); };
  const auto nearest =
      std::min_element(middles.begin(), middles.end(),
                       [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  const UncertainMotion& anchor =
      tiles.stored()[std::size_t(nearest - middles.begin())].T_map_anchor;
  const Eigen::Matrix3d Ad = anchor.motion.between(pose).inverse().adjoint();
  return {pose, covariance + Ad * anchor.covariance * Ad.transpose()};
}

}  // namespace

/// The points of a stretch on surfaces that none before has shown: each counts once.
std::vector<SurfacePoint> FollowedPlaces::fresh_of(const std::vector<SurfacePoint>& points,
                                                   const SE2& stretch) {
  std::vector<SurfacePoint> fresh;
  std::set<std::pair<int, int>> now;
  for (const SurfacePoint& point : points) {
    const Eigen::Vector2d p = (stretch * point.position) / kIndependent;
    const std::pair<int, int> name{int(std::floor(p.x())), int(std::floor(p.y()))};
    if (seen_.count(name) == 0) fresh.push_back(point);
    now.insert(name);
  }
  seen_.merge(now);
  return fresh;
}

/// What a stretch says of a place at which it is aligned, by surfaces that have not counted yet.
void FollowedPlaces::count(PlaceTiles& tiles, const ScanAlignment& found,
                           const std::vector<SurfacePoint>& fresh, const SE2& stretch,
                           ScanPlace& at) const {
  const auto [on, off] = tiles.lengths_at(fresh, found.pose);
  at.on += on;
  at.off += off;
  at.fit += fit_of(on, off);
  if (found.inliers < options_.min_inliers) return;
  const UncertainMotion here = with_map(tiles, found.pose, alignment_covariance(found));
  const Eigen::Matrix3d Ad = stretch.adjoint();
  at.T_map_drive = {here.motion * stretch.inverse(), Ad * here.covariance * Ad.transpose()};
  at.stretch = stretch;
  if (is_apart(at.seen_from, found.pose.translation(), options_.query_length)) {
    at.seen_from.push_back(found.pose.translation());
  }
}

void FollowedPlaces::look(PlaceTiles& tiles, const std::vector<SurfacePoint>& points,
                          const SE2& stretch) {
  const std::vector<SurfacePoint> fresh = fresh_of(points, stretch);
  for (ScanPlace& place : places_) {
    const auto found = tiles.align_at(points, place.T_map_drive.motion * stretch);
    if (found) count(tiles, *found, fresh, stretch, place);
  }
  forget_weak();
  for (const MatchMode& mode : tiles.search(points, options_of_match(options_))) {
    const SE2& here = mode.pose.motion;
    const bool known = std::any_of(places_.begin(), places_.end(), [&](const ScanPlace& p) {
      return is_one_place(p.T_map_drive.motion * stretch, here);
    });
    const bool allowed = is_allowed(options_.start, here * stretch.inverse());
    const auto found = known || !allowed ? std::nullopt : tiles.align_at(points, here);
    if (found) count(tiles, *found, points, stretch, places_.emplace_back());
  }
  forget_weak();
}

/// Keeps the best of places that have become one, and the best of all for which anything speaks.
void FollowedPlaces::forget_weak() {
  std::stable_sort(places_.begin(), places_.end(),
                   [](const ScanPlace& a, const ScanPlace& b) { return a.fit > b.fit; });
  std::vector<ScanPlace> kept;
  for (ScanPlace& place : places_) {
    const SE2 here = place.T_map_drive.motion * place.stretch;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const ScanPlace& p) {
      return is_one_place(p.T_map_drive.motion * place.stretch, here);
    });
    const bool fits = place.fit >= 0 && !place.seen_from.empty();
    if (fits && !known && kept.size() < kMostPlaces) kept.push_back(std::move(place));
  }
  places_ = std::move(kept);
}

ScanPlaceSearch::ScanPlaceSearch(std::vector<StoredScans> stored, const ScanPlaceOptions& options)
    : options_(options),
      tiles_(std::move(stored), options.map_length),
      drive_(options),
      mirrored_(options),
      next_(options.query_length) {}

const ScanPlace* ScanPlaceSearch::look(const std::vector<SurfacePoint>& points,
                                       const SE2& stretch) {
  const std::vector<SurfacePoint> query = within(PlaceTiles::kView, points);
  if (query.empty() || tiles_.stored().empty()) return nullptr;
  drive_.look(tiles_, query, stretch);
  if (!options_.start) mirrored_.look(tiles_, mirror_image(query), mirror_image(stretch));
  for (const ScanPlace& place : mirrored_.places()) by_chance_ = std::max(by_chance_, place.fit);
  return stands_out() ? &places().front() : nullptr;
}

double ScanPlaceSearch::log_odds() const {
  if (places().empty()) return 0.0;
  const double other = places().size() > 1 ? places()[1].fit : 0.0;
  return places().front().fit - std::max(other, by_chance_);
}

bool ScanPlaceSearch::stands_out() const {
  const int votes = options_.start ? 1 : options_.votes;
  return !places().empty() && static_cast<int>(places().front().seen_from.size()) >= votes &&
         log_odds() > std::log(options_.odds);
}

bool ScanPlaceSearch::is_due(double way) {
  if (way < next_) return false;
  next_ = way + std::max(options_.every, kLater * way);
  return true;
}

std::optional<UncertainMotion> ScanPlaceSearch::look(const ScanMapper& mapper) {
  const ScanTracker& tracker = mapper.tracker();
  if (tracker.keyframes().empty()) return std::nullopt;
  if (!is_due(tracker.keyframes().back().travelled)) return std::nullopt;
  const std::size_t last = tracker.keyframes().size() - 1;
  const SE2 newest = mapper.pose(last);
  const ScanPlace* found = look(recent_points(tracker, options_.query_length), newest);
  if (found == nullptr) return std::nullopt;
  const UncertainMotion here =
      found->T_map_drive * UncertainMotion{newest, Eigen::Matrix3d::Zero()};
  return here * mapper.relation(last, 0);
}

}  // namespace hybrid
