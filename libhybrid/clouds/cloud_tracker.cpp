// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/clouds/pose_preference.h"
#include "libhybrid/core/evenly_chosen.h"

namespace hybrid {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Errors of the prediction of the next cloud: by odometry these shares of the motion beside what
/// is stated, and at least [m], [rad]; by a steady motion shares of the reach and of the last
/// motion.
constexpr double kOfMotion = 0.1;
constexpr double kLeastTranslation = 0.02;
constexpr double kLeastRotation = 0.01;
constexpr double kSteadyOfReach = 0.02;
constexpr double kSteadyOfMotion = 0.3;
constexpr double kSteadyRotation = 0.05;
constexpr double kBegunOfReach = 0.1;  // of a motion that begins
/// Surfaces are matched badly where another start may find a better pose.
constexpr double kDoubtful = 0.7;
constexpr float kLevel = 0.7F;  // cosine between a normal and the vertical
/// Turns of the prediction about the vertical that are tried then [rad].
constexpr double kTurns[] = {-0.9, -0.6, -0.3, 0, 0.3, 0.6, 0.9};
/// Motions from the cloud before, ahead and to the left, in reaches.
constexpr std::pair<double, double> kMoves[] = {{-0.3, 0}, {-0.15, 0}, {0.15, 0},
                                                {0.3, 0},  {0, -0.15}, {0, 0.15}};
/// So many points choose among these, one of which is better by such a share on surfaces where
/// odometry says otherwise.
constexpr std::size_t kStartPoints = 400;
constexpr double kClearlyBetter = 0.05;
/// That one is taken if all points prefer it by so much, see preference(), with cubes of such an
/// edge, in reaches.
constexpr double kPreferred = 25;
constexpr double kBlock = 0.2;
constexpr double kOneTurn = 0.02;  // rad, between starts that lead to one pose
/// They are first moved onto surfaces of so many spacings, which catch them from farther.
constexpr double kCoarse = 3;
/// There, a pose that is so many standard deviations from the prediction is none: floors and
/// ceilings of any two places lie on each other.
constexpr double kSurprise = 5;
/// A cloud of fewer points with normals tells nothing.
constexpr std::size_t kFewKnown = 30;
/// Points are added to a local map after a motion of a spacing, or such a turn [rad].
constexpr double kAddTurn = 0.05;
/// One cloud that agrees with nothing may be of another sensor; so many begin a map of their own.
constexpr std::size_t kLostInRow = 2;
/// Until a cloud agrees with another, one that sees so many times as far shows the reach of the
/// sensor: the clouds before it were of the robot itself, or of a hand.
constexpr double kLonger = 2;

Matrix6 prediction_covariance(const std::optional<UncertainMotion3>& odometry, const SE3& last,
                              double reach) {
  const SE3& motion = odometry ? odometry->motion : last;
  const double d = motion.translation().norm(), a = motion.rotation().log().norm();
  if (!odometry) {
    return isotropic_covariance(kSteadyOfReach * reach + kSteadyOfMotion * d,
                                kSteadyRotation + kSteadyOfMotion * a);
  }
  return odometry->covariance +
         isotropic_covariance(kLeastTranslation + kOfMotion * d, kLeastRotation + kOfMotion * a);
}

/// Of a motion that may begin or end, where odometry does not tell it.
Matrix6 changes(const std::optional<UncertainMotion3>& odometry, double reach) {
  Matrix6 out = Matrix6::Zero();
  if (!odometry) out.diagonal().head<3>().setConstant(std::pow(kBegunOfReach * reach, 2));
  return out;
}

bool is_near(const SE3& a, const SE3& b, double distance) {
  const SE3 off = a.between(b);
  return off.translation().norm() < distance && off.rotation().log().norm() < kOneTurn;
}

bool is_likely(const SE3& pose, const SE3& predicted, const Matrix6& covariance) {
  const Vector6 off = predicted.between(pose).log();
  return off.dot(covariance.ldlt().solve(off)) < kSurprise * kSurprise;
}

/// Where a cloud may be that is not where it should be: turned, or, where odometry does not tell
/// its motion, moved from the one before.
std::vector<SE3> starts_near(const SE3& predicted, const SE3& last, bool has_odometry,
                             double reach) {
  std::vector<SE3> out;
  for (const SE3& centre : {predicted, last}) {
    for (const double turn : kTurns) {
      out.push_back(centre * SE3({0, 0, 0}, SO3::exp(Eigen::Vector3d(0, 0, turn))));
    }
  }
  if (has_odometry) return out;
  for (const auto& [ahead, left] : kMoves) {
    out.push_back(last * SE3(reach * Eigen::Vector3d(ahead, left, 0), SO3()));
  }
  return out;
}

/// At most `most` points, of which those on level surfaces, which tell neither place nor heading,
/// are no more than the others where there are enough of these.
std::vector<CloudPoint> balanced(const std::vector<CloudPoint>& points, std::size_t most) {
  std::vector<CloudPoint> level, steep;
  for (const CloudPoint& point : points) {
    if (!point.has_normal()) continue;
    (std::abs(point.normal.z()) > kLevel ? level : steep).push_back(point);
  }
  steep = evenly_chosen(steep, std::max(most / 2, most - std::min(most, level.size())));
  level = evenly_chosen(level, most - steep.size());
  steep.insert(steep.end(), level.begin(), level.end());
  return steep;
}

}  // namespace

/// The best pose near a prediction.
CloudAlignment CloudTracker::aligned(const std::vector<CloudPoint>& points, const SE3& predicted,
                                     const Matrix6& covariance, bool has_odometry) const {
  CloudAlignmentOptions options;
  options.prior = covariance.inverse();
  CloudAlignment best = align(points, *surfaces_, predicted, options);
  if (has_odometry && best.inliers >= kDoubtful) return best;
  const std::vector<CloudPoint> few = evenly_chosen(points, kStartPoints);
  CloudAlignmentOptions quick;
  quick.with_information = false;
  CloudAlignment likely = align(few, *surfaces_, best.pose, quick);
  const double expected = likely.support;
  std::vector<SE3> seen;
  for (const SE3& start : starts_near(predicted, maps_.back().poses.back(), has_odometry, reach_)) {
    const SE3 near = align(few, *coarse_, start, quick).pose;
    const auto is_here = [&](const SE3& other) {
      return is_near(near, other, surfaces_->spacing());
    };
    if (std::any_of(seen.begin(), seen.end(), is_here)) continue;
    seen.push_back(near);
    const CloudAlignment other = align(few, *surfaces_, near, quick);
    if (other.support > likely.support) likely = other;
  }
  if (has_odometry && likely.support < expected + kClearlyBetter) return best;
  const CloudAlignment other = align(points, *surfaces_, likely.pose);
  return is_better(other, best, points) ? other : best;
}

/// The second cloud has a map of one, and no motion is known that might go on.
bool CloudTracker::is_better(const CloudAlignment& other, const CloudAlignment& expected,
                             const std::vector<CloudPoint>& points) const {
  const bool is_second = maps_.size() == 1 && maps_.back().poses.size() == 1;
  if (is_second) return other.support > expected.support;
  return preference(points, *surfaces_, *coarse_, expected.pose, other.pose, kBlock * reach_) >
         kPreferred;
}

/// Surfaces of the last local map, without any yet.
void CloudTracker::make_surfaces() {
  surfaces_.emplace(options_.spacing * reach_);
  coarse_.emplace(kCoarse * options_.spacing * reach_);
}

void CloudTracker::add_surfaces(const Added& added, const SE3& pose) {
  const std::vector<CloudPoint> points = transformed(pose, added.points);
  surfaces_->add(points, shifts_at(added.pose, added.points, added.shifts));
  coarse_->add(points);
}

/// Begins a local map with the second half of the present one, which is complete then.
void CloudTracker::begin_map() {
  LocalCloud& before = maps_.back();
  before.points = surfaces_->points();
  const double middle = before.travelled.back() - 0.5 * options_.map_length * reach_;
  std::size_t k = 1;
  while (k + 1 < before.poses.size() && before.travelled[k] < middle) ++k;
  LocalCloud next;
  next.anchor = before.anchor + k;
  recent_.erase(recent_.begin(), recent_.begin() + static_cast<std::ptrdiff_t>(k));
  make_surfaces();
  const SE3 anchor = before.poses[k];
  const PoseShifts of_anchor = recent_.front().pose;
  for (std::size_t i = k; i < before.poses.size(); ++i) {
    const SE3 pose = anchor.between(before.poses[i]);
    next.poses.push_back(pose);
    next.travelled.push_back(before.travelled[i]);
    recent_[i - k].pose -= pose.inverse().adjoint() * of_anchor;
    add_surfaces(recent_[i - k], pose);
  }
  maps_.push_back(std::move(next));
}

/// Begins a local map with the newest cloud alone.
void CloudTracker::begin_map_anew() {
  double travelled = 0;
  if (!maps_.empty()) {
    if (surfaces_) maps_.back().points = surfaces_->points();
    travelled = maps_.back().travelled.back();
  }
  LocalCloud next;
  next.anchor = clouds_;
  next.travelled.push_back(travelled);
  next.poses.emplace_back();
  maps_.push_back(std::move(next));
  recent_.clear();
  recent_.push_back({PoseShifts::Zero(), newest_, sweep_.shifts_of(newest_)});
  if (reach_ > 0) {
    make_surfaces();
    add_surfaces(recent_.back(), SE3());
  }
  since_added_ = SE3();
}

/// Adds the newest cloud, which is at `pose` in the last local map, and its surfaces where these
/// agree with the others.
void CloudTracker::add(const SE3& pose, const PoseShifts& shifts, bool agrees) {
  LocalCloud& map = maps_.back();
  map.poses.push_back(pose);
  map.travelled.push_back(map.travelled.back() + last_motion_.translation().norm());
  recent_.push_back({shifts, {}, {}});
  since_added_ = since_added_ * last_motion_;
  since_added_.normalize();
  const bool is_new = surfaces_ && (since_added_.translation().norm() > surfaces_->spacing() ||
                                    since_added_.rotation().log().norm() > kAddTurn);
  if (agrees && is_new) {
    recent_.back().points = newest_;
    recent_.back().shifts = sweep_.shifts_of(newest_);
    add_surfaces(recent_.back(), pose);
    since_added_ = SE3();
  }
  const double way = map.travelled.back() - map.travelled.front();
  if (surfaces_ && map.poses.size() > 2 && way > options_.map_length * reach_) begin_map();
}

/// The first cloud, the first one with surfaces, or the first that shows the reach of the sensor.
TrackedCloud CloudTracker::begin(const std::optional<UncertainMotion3>& odometry) {
  TrackedCloud out;
  out.cloud = clouds_;
  if (!maps_.empty() && odometry) out.T_before_cloud = odometry->motion;
  if (newest_.empty()) ++blind_;
  begin_map_anew();
  ++clouds_;
  return out;
}

TrackedCloud CloudTracker::track(const std::vector<Eigen::Vector3f>& points,
                                 const Eigen::Vector3f& sensor,
                                 const std::optional<UncertainMotion3>& odometry, bool is_at_once) {
  const double reach = has_matched_ ? 0 : reach_of(points, sensor);
  const bool is_first = reach > kLonger * reach_;
  if (is_first) reach_ = reach;
  newest_.clear();
  const SE3 expected = odometry ? odometry->motion : last_motion_;
  if (reach_ > 0) {
    newest_ = cloud_points(sweep_.deskewed(points, sensor, expected, is_at_once), sensor,
                           options_.spacing * reach_);
  }
  if (maps_.empty() || is_first) return begin(odometry);
  const SE3 before = maps_.back().poses.back();
  const SE3 predicted = before * expected;
  const std::vector<CloudPoint> used = balanced(newest_, options_.most_points);
  const bool tells = surfaces_ && used.size() >= kFewKnown;
  const Matrix6 covariance = prediction_covariance(odometry, last_motion_, reach_);
  CloudAlignment found;
  if (tells) found = aligned(used, predicted, covariance, odometry.has_value());
  const bool good = tells && found.inliers >= options_.min_inliers &&
                    (found.inliers >= kDoubtful ||
                     is_likely(found.pose, predicted, covariance + changes(odometry, reach_)));
  SE3 pose = good ? found.pose : predicted;
  pose.normalize();
  last_motion_ = before.between(pose);
  TrackedCloud out;
  out.cloud = clouds_;
  out.T_before_cloud = last_motion_;
  out.inliers = found.inliers;
  out.is_lost = tells && !good;
  has_matched_ = has_matched_ || good;
  if (good) out.match = {clouds_ - 1, {last_motion_, alignment_covariance(found)}};
  blind_ += tells ? 0 : 1;
  lost_ += out.is_lost ? 1 : 0;
  lost_in_row_ = out.is_lost ? lost_in_row_ + 1 : 0;
  if (lost_in_row_ == kLostInRow) {
    begin_map_anew();
  } else {
    PoseShifts shifts = last_motion_.inverse().adjoint() * recent_.back().pose;
    if (good) {
      shifts = sweep_.learn(used, *surfaces_, found, {predicted, covariance.inverse(), shifts});
    }
    add(pose, shifts, good);
  }
  ++clouds_;
  return out;
}

}  // namespace hybrid
