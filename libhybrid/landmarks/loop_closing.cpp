// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/loop_closing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "libhybrid/association/consensus.h"
#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/factors/sensor_view.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostAnchors = 20;  // each is a search of its own, of a share of ...
constexpr int kMostFollowed = 2000;       // ... these pairs of pairs
constexpr int kAnswers = 8;               // of each, to compare with those of the others
constexpr double kStretch = 5;            // ranges of the sensor that make a stretch of the way
constexpr std::size_t kFewest = 3;        // landmarks that can be a place
constexpr std::size_t kMostOfPlace = 40;  // landmarks of one that are compared: a budget
constexpr std::size_t kClutter = 100;     // births in a row, none confirmed, that are clutter

/// Landmarks in the frame of a pose.
template <class Pose>
Constellation<Pose> seen_from(Key pose, const std::vector<int>& tracks, const MapView& map,
                              const LandmarkTracks& landmarks) {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  using Matrix = typename Constellation<Pose>::Matrix;
  const Pose T_map_pose = map.values.at<Pose>(pose);
  const Pose T_pose_map = T_map_pose.inverse();
  const Matrix turned = T_map_pose.rotation().matrix().transpose();
  const auto dims = static_cast<Eigen::Index>(kDim * tracks.size());
  std::vector<Key> keys = {pose};
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(dims, Pose::kDim + dims);
  Constellation<Pose> out;
  for (const int t : tracks) {
    const Key position = landmarks.track(t).position;
    const auto row = static_cast<Eigen::Index>(kDim * out.points.size());
    keys.push_back(position);
    out.points.push_back(T_pose_map * map.values.at<typename Pose::Point>(position));
    J.block<kDim, kDim>(row, 0) = -Matrix::Identity();
    J.block<kDim, Pose::kDim - kDim>(row, kDim) = rotation_derivative(out.points.back());
    J.block<kDim, kDim>(row, Pose::kDim + row) = turned;
  }
  const Eigen::MatrixXd joint = map.covariance_of(keys, J);
  for (Eigen::Index row = 0; row < dims; row += kDim)
    out.covariances.push_back(joint.block<kDim, kDim>(row, row));
  return out;
}

/// Whether no landmark of place a comes within `radius` of place b with all that the drift allows.
template <class Pose>
bool out_of_reach(const ConstellationMatchProblem<Pose>& q, double radius, double gate) {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  const double sigmas = std::sqrt(chi_square_quantile(gate, kDim));
  const auto variances = q.covariance.diagonal();
  const double drift = variances.template head<kDim>().sum();
  const double turn = variances.template tail<Pose::kDim - kDim>().sum();
  const typename Pose::Point b = q.T_a_b.translation();
  return std::none_of(q.a.points.begin(), q.a.points.end(), [&](const auto& p) {
    const double apart = (p - b).norm();
    return apart <= radius + sigmas * std::sqrt(drift + apart * apart * turn);
  });
}

/// log evidence of their classes that a recent landmark (row) and an old one (column) are one.
Eigen::MatrixXd class_ratios(const std::vector<int>& recent, const std::vector<int>& old,
                             const ClassModel& classes, const LandmarkTracks& landmarks) {
  Eigen::MatrixXd ratios(recent.size(), old.size());
  for (std::size_t i = 0; i < recent.size(); ++i) {
    for (std::size_t j = 0; j < old.size(); ++j) {
      ratios(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          landmarks.seen_together(recent[i], old[j])
              ? -std::numeric_limits<double>::infinity()
              : landmarks.same_class(recent[i], old[j], classes);
    }
  }
  return ratios;
}

/// Tracks so far, one more at the end, when all is asked once more.
std::size_t count_of(bool concluding, const LandmarkTracks& landmarks) {
  return landmarks.tracks().size() + (concluding ? 1 : 0);
}

/// Where a pose of the map is [m].
Eigen::Vector3d point_of(const Values& values, Key pose) {
  return isometry_at(values, pose).translation();
}

/// A way to see the last stretch as a place of the map.
struct Recognition {
  std::vector<std::pair<int, int>> pairs;  // of tracks
  double cost = 0, chi_square = 0;
};

bool contradict(const std::pair<int, int>& p, const std::pair<int, int>& q) {
  return (p.first == q.first) != (p.second == q.second);
}

/// The pairs of the best recognition that none nearly as good contradicts; none if it is not
/// decisive. Once nothing more can be learned, being the best is enough.
Merge decided(std::vector<Recognition> found, double margin, bool concluding) {
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& x, const auto& y) { return x.cost < y.cost; });
  Merge merge;
  if (found.empty() || found.front().cost > -margin) return merge;
  const Recognition& best = found.front();
  merge.pairs =
      concluding ? best.pairs : undisputed(found, margin, [](const auto& p, const auto& q) {
        return contradict(p, q);
      });
  if (2 * merge.pairs.size() < best.pairs.size()) merge.pairs.clear();
  merge.evidence = -best.cost;
  merge.chi_square = best.chi_square;
  merge.loop = true;
  return merge;
}

}  // namespace

void LoopClosing::looked(const KeyframeView& frame, const Eigen::Isometry3d& T_robot_sensor,
                         const SensorCoverage& coverage, double density, const MapView& map) {
  views_.add(frame, T_robot_sensor, coverage, map);
  const std::size_t newest = views_.size() - 1;
  const auto is_too_far = [&](const View& view) {
    return views_[newest].travelled - view.travelled > span() ||
           (view.pose != frame.pose && chance(view, frame, density, map) > 1);
  };
  while (first_recent_ < newest && is_too_far(views_[first_recent_])) ++first_recent_;
}

void LoopClosing::take_back() {
  views_.resize(before_.views);
  first_recent_ = before_.first_recent;
}

/// Landmarks to expect by chance where the drift since a view lets one be.
double LoopClosing::chance(const View& view, const KeyframeView& frame, double density,
                           const MapView& map) const {
  if (!map.holds(view.pose)) return std::numeric_limits<double>::infinity();
  const auto drift = [&](const auto& T_map_view, const auto& T_map_robot) {
    using Pose = std::decay_t<decltype(T_map_view)>;
    constexpr int kDim = Pose::Point::RowsAtCompileTime;
    const typename Pose::Jacobian P =
        covariance_of_motion(frame, view.pose, T_map_robot.between(T_map_view).adjoint());
    const double turn = P.diagonal().tail(Pose::kDim - kDim).sum();
    const double range = 0.5 * view.coverage.max_range;
    Eigen::Matrix<double, kDim, kDim> spread = P.template topLeftCorner<kDim, kDim>();
    spread.diagonal().array() += range * range * turn;
    return std::sqrt((2 * M_PI * spread).determinant());
  };
  return density * (map.is_3d ? drift(map.values.at<SE3>(view.pose), to_se3(frame.T_map_robot))
                              : drift(map.values.at<SE2>(view.pose), to_se2(frame.T_map_robot)));
}

/// Length of a stretch of the way, by the sensor that sees farthest [m].
double LoopClosing::span() const {
  return kStretch * views_.reach();
}

std::vector<int> LoopClosing::recent_tracks(int sightings, const MapView& map,
                                            const LandmarkTracks& landmarks) const {
  std::vector<int> tracks;
  for (int t = static_cast<int>(landmarks.tracks().size()) - 1; t >= 0; --t) {
    const Track& track = landmarks.track(t);
    if (!track.alive || track.open > 0 || !map.holds(track.position)) continue;
    if (is_old(t, landmarks) || tracks.size() == kMostOfPlace) break;
    if (landmarks.seen_times(t, sightings)) tracks.push_back(t);
  }
  std::reverse(tracks.begin(), tracks.end());
  return tracks;
}

/// Whether a landmark was first seen before the last stretch.
bool LoopClosing::is_old(int track, const LandmarkTracks& landmarks) const {
  return landmarks.first_seen_from(track) < views_[first_recent_].pose;
}

/// Earlier views within `radius` of where the robot is, the nearest that are not near another. It
/// is looked for in ever wider circles: however far the way has drifted, there are not many.
std::vector<std::size_t> LoopClosing::anchors(const MapView& map, double radius) const {
  std::vector<std::size_t> out;
  for (double within = std::min(span(), radius);; within = std::min(2 * within, radius)) {
    out = anchors_within(map, within);
    if (out.size() == kMostAnchors || !(within < radius)) return out;
  }
}

std::vector<std::size_t> LoopClosing::anchors_within(const MapView& map, double radius) const {
  const Eigen::Vector3d here = point_of(map.values, views_.back().pose);
  const double apart = views_.reach();
  std::vector<std::pair<double, std::size_t>> near;
  views_.visit_near(here, radius, [&](std::size_t view) {
    if (view >= first_recent_ || !map.holds(views_[view].pose)) return;
    const double distance = (point_of(map.values, views_[view].pose) - here).norm();
    if (distance <= radius) near.emplace_back(distance, view);
  });
  std::sort(near.begin(), near.end());
  std::vector<std::size_t> out;
  std::vector<Eigen::Vector3d> taken;
  for (const auto& [distance, view] : near) {
    const Eigen::Vector3d p = point_of(map.values, views_[view].pose);
    const bool crowded = std::any_of(taken.begin(), taken.end(), [&](const Eigen::Vector3d& q) {
      return (p - q).norm() < apart;
    });
    if (crowded || out.size() == kMostAnchors) continue;
    out.push_back(view);
    taken.push_back(p);
  }
  return out;
}

std::vector<int> LoopClosing::tracks_about(const Eigen::Vector3d& center, int sightings,
                                           const MapView& map,
                                           const LandmarkTracks& landmarks) const {
  const double radius = 0.5 * span();
  std::vector<std::pair<double, int>> near;
  landmarks.grid().visit_near(center.x(), center.y(), radius, [&](int t) {
    const Track& track = landmarks.track(t);
    if (!track.alive || track.open > 0 || !map.holds(track.position)) return;
    if (!landmarks.seen_times(t, sightings) || !is_old(t, landmarks)) return;
    near.emplace_back((point_at(map.values, track.position) - center).norm(), t);
  });
  std::sort(near.begin(), near.end());
  if (near.size() > kMostOfPlace) near.resize(kMostOfPlace);
  std::vector<int> tracks;
  for (const auto& [distance, t] : near) tracks.push_back(t);
  return tracks;
}

bool LoopClosing::covered(const Eigen::Vector3d& point, const std::vector<std::size_t>& views,
                          const MapView& map) const {
  return std::any_of(views.begin(), views.end(),
                     [&](std::size_t v) { return views_.covers(v, point, map); });
}

void LoopClosing::note(bool concluding, const LandmarkTracks& landmarks) {
  if (!views_.empty()) asked_ = count_of(concluding, landmarks);
}

/// Tentative landmarks count only where confirmed ones do not tell: more of them are clutter.
Merge LoopClosing::propose(const MapView& map, const ClassModel& classes, double density,
                           bool concluding, const LandmarkTracks& landmarks) const {
  if (views_.empty() || count_of(concluding, landmarks) == asked_) return {};
  const auto among = [&](int sightings) {
    return map.is_3d ? propose_among<SE3>(sightings, map, classes, density, concluding, landmarks)
                     : propose_among<SE2>(sightings, map, classes, density, concluding, landmarks);
  };
  Merge merge = among(options_.confirm);
  if (!merge.pairs.empty() || (!concluding && is_clutter(landmarks))) return merge;
  return among(1);
}

/// Whether nothing of what was born lately has been seen often enough to be a landmark, so that
/// what is tentative is no place: in a map all of which is clutter, as where odometry is in other
/// units than ranges are, every keyframe would ask a search of all of it.
bool LoopClosing::is_clutter(const LandmarkTracks& landmarks) const {
  const std::size_t count = landmarks.tracks().size();
  if (count < kClutter) return false;
  for (std::size_t t = count - kClutter; t < count; ++t) {
    if (landmarks.seen_times(static_cast<int>(t), options_.confirm)) return false;
  }
  return true;
}

/// The place about an earlier view, as the one to compare `question.a` with. Returns its landmarks;
/// none where it is out of reach, or has too few.
template <class Pose>
std::vector<int> LoopClosing::ask_about(std::size_t view, int sightings, const MapView& map,
                                        const LandmarkTracks& landmarks,
                                        ConstellationMatchProblem<Pose>& question) const {
  const Key here = views_.back().pose, there = views_[view].pose;
  const Pose T_map_a = map.values.at<Pose>(here), T_map_b = map.values.at<Pose>(there);
  question.T_a_b = T_map_a.between(T_map_b);
  Eigen::MatrixXd J(Pose::kDim, 2 * Pose::kDim);
  J << -question.T_a_b.inverse().adjoint(), Pose::Jacobian::Identity();
  question.covariance = map.covariance_of({here, there}, J);
  if (out_of_reach(question, 0.5 * span(), options_.gate)) return {};
  const Eigen::Vector3d center = padded_point(T_map_b.translation());
  std::vector<int> old = tracks_about(center, sightings, map, landmarks);
  if (old.size() < kFewest) return {};
  question.b = seen_from<Pose>(there, old, map, landmarks);
  std::vector<std::size_t> views;
  views_.visit_near(center, 0.5 * span(), [&](std::size_t v) {
    if (v < first_recent_) views.push_back(v);
  });
  question.b.covers = [this, T_map_b, views, &map](const typename Pose::Point& p) {
    return covered(padded_point(T_map_b * p), views, map);
  };
  return old;
}

template <class Pose>
Merge LoopClosing::propose_among(int sightings, const MapView& map, const ClassModel& classes,
                                 double density, bool concluding,
                                 const LandmarkTracks& landmarks) const {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  const std::vector<int> recent = recent_tracks(sightings, map, landmarks);
  if (recent.size() < kFewest) return {};
  const Key here = views_.back().pose;
  const Eigen::MatrixXd drift = map.joint_covariance({here}).topLeftCorner(kDim, kDim);
  const double chance_here = density * std::sqrt((2 * M_PI * drift).determinant());
  // Whether single landmarks can be told anywhere.
  if (chance_here * options_.old_landmark_odds < 1) return {};
  const double gate = std::sqrt(chi_square_quantile(options_.gate, kDim));
  const std::vector<std::size_t> near =
      anchors(map, gate * std::sqrt(drift.trace()) + 0.5 * span());
  if (near.empty()) return {};

  ConstellationMatchProblem<Pose> question;
  const Pose T_map_a = map.values.at<Pose>(here);
  question.a = seen_from<Pose>(here, recent, map, landmarks);
  question.log_density = std::log(density);
  question.missed =
      -std::log1p(-views_.back().coverage.detection_probability(options_.detection_probability));
  std::vector<std::size_t> views;
  for (std::size_t v = first_recent_; v < views_.size(); ++v) views.push_back(v);
  question.a.covers = [&](const typename Pose::Point& p) {
    return covered(padded_point(T_map_a * p), views, map);
  };
  PlaceOptions options;
  options.gate = options_.gate;
  options.answers = kAnswers;
  options.hypotheses = kMostFollowed / static_cast<int>(near.size());
  std::vector<Recognition> found;
  for (const std::size_t view : near) {
    const std::vector<int> old = ask_about(view, sightings, map, landmarks, question);
    if (old.empty()) continue;
    question.class_log_likelihood_ratio = class_ratios(recent, old, classes, landmarks);
    for (const ConstellationMatch<Pose>& answer : match_places(question, options)) {
      Recognition r{{}, answer.cost, answer.chi_square};
      for (const auto& [i, j] : answer.pairs) r.pairs.emplace_back(recent[i], old[j]);
      found.push_back(std::move(r));
    }
  }
  return decided(std::move(found), std::log(options_.merge_odds), concluding);
}

}  // namespace hybrid
