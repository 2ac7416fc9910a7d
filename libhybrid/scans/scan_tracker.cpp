// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_tracker.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "libhybrid/core/evenly_chosen.h"

namespace hybrid {
namespace {

/// Errors of the prediction of the next scan: of odometry at scale 1 these are generous; a steady
/// motion knows nothing of acceleration [m], [rad].
constexpr double kPredictedTranslation = 0.02;
constexpr double kPredictedRotation = 0.01;
constexpr double kSteadyTranslation = 0.04;
constexpr double kSteadyRotation = 0.05;
/// The least motion between keyframes where much is new [m], [rad].
constexpr double kDenseDistance = 0.2;
constexpr double kDenseTurn = 0.1;
/// Surfaces are matched badly where a search may find a better pose.
constexpr double kDoubtful = 0.7;
/// What a point on a surface rather than off it tells for a pose, and what a prediction that was a
/// blunder tells against it at most [nats].
constexpr double kPointEvidence = 1.0;
constexpr double kBlunderEvidence = 10.0;
/// Standard deviations of the prediction that a search covers, and its least and largest reach [m],
/// [rad].
constexpr double kSearched = 3.0;
constexpr double kLeastReach = 0.3;
constexpr double kMostReach = 1.5;
constexpr double kLeastTurn = 0.1;
constexpr double kMostTurn = 0.8;
/// Where that fails, odometry was wrong or scans are missing: the window is as large as this [m],
/// [rad]. Odometry that is late by a scan is no farther off.
constexpr double kLostReach = 2.0;
constexpr double kLostTurn = 1.6;
/// Standard deviations of the prediction of a scan that agrees with no map [m], [rad].
constexpr double kLostTranslation = 0.3;
constexpr double kLostRotation = 0.15;
/// The same of a robot that was carried: to the next room, and set down in any direction.
constexpr double kCarriedTranslation = 10.0;
constexpr double kCarriedRotation = 1.8;
/// A scan of fewer points tells nothing.
constexpr std::size_t kFewPoints = 10;
/// So many points of a scan, evenly chosen, tell whether a local map has its view.
constexpr std::size_t kPointsOfView = 20;
/// Odometry that differs from a match by more standard deviations than this is a blunder.
constexpr double kBlunder = 4.0;
/// A motion between scans is none if it leads farther than a local map reaches [m].
constexpr double kMostMotion = 100.0;
/// Odometry that has predicted the last scans so much worse than a steady motion is not used to
/// predict the next one; how many scans count, and what a radian counts for [m].
constexpr double kMuchWorse = 2.0;
constexpr double kRemembered = 30.0;
constexpr double kLever = 1.0;
/// A motion between scans that is no error of matches [m].
constexpr double kMoves = 0.05;
/// A keyframe is about as well known as another if no standard deviation is this many times its.
constexpr double kWorse = 3.0;

/// The motion, where it may be one.
std::optional<SE2> plausible(const std::optional<SE2>& odometry) {
  const bool is_motion = odometry && odometry->translation().cwiseAbs().maxCoeff() < kMostMotion &&
                         odometry->translation().allFinite() && std::isfinite(odometry->angle());
  return is_motion ? odometry : std::nullopt;
}

/// The logarithm of the odds of a pose, up to a constant [nats].
double log_odds(const ScanAlignment& found, const UncertainMotion& predicted) {
  const Eigen::Vector3d off = predicted.motion.between(found.pose).log();
  const double against = 0.5 * off.dot(predicted.covariance.ldlt().solve(off));
  return kPointEvidence * found.support - std::min(against, kBlunderEvidence);
}

/// Whether a pose is as near to another as odometry that is late has it.
bool is_within_reach(const SE2& a, const SE2& b) {
  const SE2 off = a.between(b);
  return off.translation().norm() <= kLostReach && std::abs(off.angle()) <= kLostTurn;
}

/// In no direction is the variance of A larger than that of B.
bool is_within(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  return (B - A).llt().info() == Eigen::Success;
}

}  // namespace

/// Covariance of the prediction of the next scan, which odometry tells or else a steady motion.
Eigen::Matrix3d ScanTracker::prior(const SE2& motion, bool by_odometry) const {
  if (!by_odometry) {
    const double translation = std::hypot(kSteadyTranslation, steady_error_);
    const double rotation = std::hypot(kSteadyRotation, steady_error_ / kLever);
    return Eigen::Vector3d(translation, translation, rotation).cwiseAbs2().asDiagonal();
  }
  Eigen::Matrix3d covariance =
      noise_.covariance(motion.translation().norm(), std::abs(motion.angle()));
  covariance.diagonal() +=
      Eigen::Vector3d(kPredictedTranslation, kPredictedTranslation, kPredictedRotation).cwiseAbs2();
  return covariance;
}

/// The share of the points to which scans of the local map have looked, if these are there at that
/// pose; not counted on once it is enough to be lost. Where a laser looks for the first time, there
/// is nothing that it could agree with.
double ScanTracker::share_in_view(const std::vector<SurfacePoint>& points, const SE2& pose) const {
  const LocalMap& map = maps_.back();
  if (points.empty()) return 1.0;
  std::vector<Eigen::Vector2d> unseen = evenly_chosen(positions_of(points), kPointsOfView);
  for (Eigen::Vector2d& p : unseen) p = pose * p;
  const std::size_t used = unseen.size();
  const auto share = [&] { return 1.0 - double(unseen.size()) / double(used); };
  for (std::size_t k = map.poses.size(); k-- > 0 && share() < kDoubtful;) {
    const ScanView& view = keyframes_[map.anchor + k].view;
    const SE2 back = map.poses[k].inverse();
    unseen.erase(std::remove_if(unseen.begin(), unseen.end(),
                                [&](const Eigen::Vector2d& p) { return view.contains(back * p); }),
                 unseen.end());
  }
  return share();
}

/// The best pose in a window becomes `best` where it has better odds.
void ScanTracker::search(const std::vector<SurfacePoint>& points, const UncertainMotion& predicted,
                         const SearchWindow& window, ScanAlignment& best) {
  if (!target_) {
    target_ = std::make_shared<MatchTarget>(make_match_target(this->points(maps_.back())));
  }
  MatchOptions options;
  options.min_inliers = options_.min_inliers;
  for (const MatchMode& mode : match(points, *target_, window, options)) {
    const ScanAlignment other = align(points, *surfaces_, mode.pose.motion);
    if (log_odds(other, predicted) > log_odds(best, predicted)) best = other;
  }
}

ScanAlignment ScanTracker::aligned(const std::vector<SurfacePoint>& points,
                                   const UncertainMotion& predicted) {
  AlignmentOptions options;
  options.prior = predicted.covariance.inverse();
  ScanAlignment best = align(points, *surfaces_, predicted.motion, options);
  if (points.empty() || best.inliers >= kDoubtful) return best;
  // Odometry may be late: the robot stands, or goes on as before.
  std::vector<SE2> if_late;
  if (is_within_reach(pose_, predicted.motion)) if_late = {pose_, pose_ * last_motion_};
  for (const SE2& start : if_late) {
    const ScanAlignment other = align(points, *surfaces_, start, options);
    if (log_odds(other, predicted) > log_odds(best, predicted)) best = other;
  }
  if (best.inliers >= kDoubtful) return best;
  SearchWindow window;
  window.centre = predicted.motion;
  const Eigen::Vector3d sigmas = predicted.covariance.diagonal().cwiseSqrt();
  const double reach = kSearched * sigmas.head<2>().norm() / std::sqrt(2.0);
  window.reach.setConstant(std::clamp(reach, kLeastReach, kMostReach));
  window.turn = std::clamp(kSearched * sigmas.z(), kLeastTurn, kMostTurn);
  search(points, predicted, window, best);
  if (best.inliers >= options_.min_inliers) return best;
  const auto search_around = [&](const SE2& centre) {
    search(points, predicted, {centre, Eigen::Vector2d::Constant(kLostReach), kLostTurn}, best);
  };
  search_around(predicted.motion);
  if (!if_late.empty()) search_around(pose_);
  return best;
}

bool ScanTracker::is_due(const SE2& from_last, double inliers, KeyframeRule rule) const {
  if (keyframes_.empty() || rule == KeyframeRule::kAlways) return true;
  if (rule == KeyframeRule::kNever) return false;
  const double distance = from_last.translation().norm();
  const double turn = std::abs(from_last.angle());
  if (distance > options_.keyframe_distance || turn > options_.keyframe_turn) return true;
  if (is_lost_ && !was_lost_) return true;
  return inliers < options_.familiar && (distance > kDenseDistance || turn > kDenseTurn);
}

std::vector<SurfacePoint> ScanTracker::points(const LocalMap& map) const {
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < map.poses.size(); ++i) {
    const std::vector<SurfacePoint> seen =
        transformed(map.poses[i], keyframes_[map.anchor + i].points);
    points.insert(points.end(), seen.begin(), seen.end());
  }
  return points;
}

ScanTracker::Mark ScanTracker::mark() const {
  if (maps_.empty()) return {*this, 0, 0};
  return {*this, keyframes_.size(), maps_.size(), maps_.back().poses.size(), maps_.back().is_blind};
}

void ScanTracker::roll_back(const Mark& mark) {
  static_cast<ScanTrackerState&>(*this) = mark.state;
  keyframes_.resize(mark.keyframes);
  maps_.resize(mark.maps);
  if (maps_.empty()) return;
  maps_.back().poses.resize(mark.count);
  maps_.back().is_blind = mark.is_blind;
}

void ScanTracker::add_to_map(std::size_t keyframe, const SE2& pose) {
  LocalMap& map = maps_.back();
  map.poses.push_back(pose);
  map.is_blind = map.is_blind && keyframes_[keyframe].points.size() < kFewPoints;
}

/// Begins a local map with the second half of the present one.
void ScanTracker::begin_map() {
  const LocalMap before = maps_.back();
  const double middle = keyframes_.back().travelled - 0.5 * options_.map_length;
  std::size_t k = 1;
  while (k + 1 < before.poses.size() && (keyframes_[before.anchor + k].travelled < middle ||
                                         before.poses.size() - k > options_.map_keyframes / 2)) {
    ++k;
  }
  const SE2 anchor = before.poses[k];
  maps_.push_back({});
  maps_.back().anchor = before.anchor + k;
  for (std::size_t i = k; i < before.poses.size(); ++i) {
    add_to_map(before.anchor + i, anchor.between(before.poses[i]));
  }
  pose_ = anchor.between(pose_);
}

void ScanTracker::add_keyframe(const std::vector<SurfacePoint>& points, const SE2& pose,
                               const Eigen::Matrix3d& covariance) {
  double travelled = 0.0;
  if (keyframes_.empty()) {
    maps_.push_back({});
  } else {
    const SE2 step = maps_.back().poses.back().between(pose);
    travelled = keyframes_.back().travelled + step.translation().norm();
  }
  keyframes_.push_back({points, ScanView(points), travelled, covariance});
  if (is_lost_) {
    maps_.push_back({});
    maps_.back().anchor = keyframes_.size() - 1;
    pose_ = SE2();
  }
  add_to_map(keyframes_.size() - 1, pose_);
  const LocalMap& map = maps_.back();
  if (map.poses.size() > 2 && (travelled - keyframes_[map.anchor].travelled > options_.map_length ||
                               map.poses.size() > options_.map_keyframes)) {
    begin_map();
  }
  surfaces_ = std::make_shared<SurfaceMap>(this->points(maps_.back()));
  target_.reset();
}

/// The motion from the last keyframe by odometry, or steady where there is none.
KeyframeMotion ScanTracker::odometry_motion(const TrackedScan& scan) const {
  KeyframeMotion result{keyframes_.size() - 1, {since_keyframe_, noise_.covariance(way_, turn_)}};
  Eigen::Matrix3d& covariance = result.measured.covariance;
  if (!has_odometry_) {
    covariance.diagonal() += Eigen::Vector3d(0.5 + way_, 0.5 + way_, 0.5 + turn_).cwiseAbs2();
  } else if (scan.match) {
    const Eigen::Vector3d error = since_keyframe_.between(scan.T_keyframe_scan).log();
    const double chi_square =
        error.dot((covariance + scan.match->measured.covariance).llt().solve(error));
    covariance *= std::max(1.0, chi_square / (kBlunder * kBlunder));
  }
  if (is_lost_) {
    const double translation = is_carried_ ? kCarriedTranslation : kLostTranslation;
    const double rotation = is_carried_ ? kCarriedRotation : kLostRotation;
    covariance.diagonal() += Eigen::Vector3d(translation, translation, rotation).cwiseAbs2();
  }
  return result;
}

/// The keyframe of the local map, counted from its anchor, that a match with that covariance tells
/// the motion from: the last one that was known about as well in every direction. A scan is known
/// to the keyframes that saw what it sees, not to the anchor; one that saw a wall alone is no link.
std::size_t ScanTracker::reference(const SE2& pose, const Eigen::Matrix3d& covariance) const {
  const LocalMap& map = maps_.back();
  for (std::size_t k = map.poses.size(); k-- > 1;) {
    const SE2 turn(0.0, 0.0, pose.between(map.poses[k]).angle());
    const Eigen::Matrix3d Ad = turn.adjoint();
    const Eigen::Matrix3d known = Ad * keyframes_[map.anchor + k].covariance * Ad.transpose();
    if (is_within(known, kWorse * kWorse * covariance)) return k;
  }
  return 0;
}

/// What a scan that becomes a keyframe tells of the motion to it.
void ScanTracker::measure(const ScanAlignment& found, const SE2& pose, bool good,
                          TrackedScan& result) {
  if (good) {
    const Eigen::Matrix3d covariance = alignment_covariance(found);
    const LocalMap& map = maps_.back();
    const std::size_t from = reference(pose, covariance);
    const KeyframeMotion match{
        map.anchor + from, {map.poses[from].between(pose), covariance}, found.inliers};
    result.match = match;
    if (has_odometry_) {
      noise_.compare(stated_, since_keyframe_, way_, turn_, {result.T_keyframe_scan, covariance});
    }
  }
  result.odometry = odometry_motion(result);
}

/// Notes how well odometry and a steady motion have predicted a motion.
void ScanTracker::compare_predictions(const SE2& odometry, const SE2& motion) {
  const auto size = [](const SE2& step) {
    return step.translation().norm() + kLever * std::abs(step.angle());
  };
  const double off = size(odometry.between(motion));
  odometry_error_ += (off - odometry_error_) / kRemembered;
  steady_error_ += (size(last_motion_.between(motion)) - steady_error_) / kRemembered;
  if (size(motion) > kMoves) counts_ = off < 0.5 * size(motion);
}

/// Adds the motion since the last scan to that since the last keyframe; returns it as odometry
/// tells it, corrected.
std::optional<SE2> ScanTracker::advance(const std::optional<SE2>& stated) {
  std::optional<SE2> odometry = plausible(stated);
  stated_ = stated_ * odometry.value_or(last_motion_);
  if (odometry) odometry = noise_.corrected(*odometry);
  const SE2 motion = odometry.value_or(last_motion_);
  since_keyframe_ = since_keyframe_ * motion;
  stated_.normalize();  // products of many rotations drift from unit norm
  since_keyframe_.normalize();
  way_ += motion.translation().norm();
  turn_ += std::abs(motion.angle());
  has_odometry_ = has_odometry_ && odometry.has_value();
  return odometry;
}

TrackedScan ScanTracker::track(const std::vector<SurfacePoint>& points,
                               const std::optional<SE2>& stated, KeyframeRule rule) {
  TrackedScan result;
  if (keyframes_.empty()) {
    add_keyframe(points, SE2(), Eigen::Matrix3d::Zero());
    result.is_keyframe = true;
    return result;
  }
  const bool is_moved = rest_.is_moved(points, stated);
  const std::optional<SE2> odometry = advance(is_moved ? std::nullopt : stated);
  const bool trusts = odometry && odometry_error_ <= kMuchWorse * steady_error_;
  const SE2 expected = trusts ? *odometry : last_motion_;
  const SE2 predicted = pose_ * expected;
  const double in_view = share_in_view(points, predicted);
  const bool is_known = in_view >= options_.min_inliers;
  const ScanAlignment found =
      is_known ? aligned(points, {predicted, prior(expected, trusts)}) : ScanAlignment();
  // Where odometry did not count before either, the robot may drive.
  const bool is_carried = is_moved && counts_;
  if (is_carried) ++carried_;
  is_carried_ = is_carried_ || is_carried;
  // From where it was set down, it is in no local map.
  const bool good = is_known && !is_carried_ && found.inliers >= options_.min_inliers;
  const bool lost = is_carried || (in_view >= kDoubtful && !good && points.size() >= kFewPoints &&
                                   !maps_.back().is_blind);
  // What no scan tells is up to odometry.
  SE2 pose = good ? found.pose : pose_ * odometry.value_or(last_motion_);
  pose.normalize();
  if (lost) ++lost_;
  is_lost_ = is_lost_ || lost;
  if (good && odometry) compare_predictions(*odometry, pose_.between(pose));
  last_motion_ = pose_.between(pose);
  pose_ = pose;
  result.keyframe = keyframes_.size() - 1;
  result.T_keyframe_scan = maps_.back().poses.back().between(pose);
  result.T_before_scan = result.T_keyframe_scan;
  result.inliers = found.inliers;
  if (!is_due(result.T_keyframe_scan, found.inliers, rule)) return result;

  measure(found, pose, good, result);
  add_keyframe(points, pose,
               result.match ? result.match->measured.covariance : alignment_covariance({}));
  result.keyframe = keyframes_.size() - 1;
  result.is_keyframe = true;
  result.T_keyframe_scan = SE2();
  begin_keyframe();
  return result;
}

/// What is kept since the last keyframe begins anew.
void ScanTracker::begin_keyframe() {
  stated_ = since_keyframe_ = SE2();
  way_ = turn_ = 0.0;
  has_odometry_ = true;
  was_lost_ = is_lost_;
  is_lost_ = is_carried_ = false;
}

}  // namespace hybrid
