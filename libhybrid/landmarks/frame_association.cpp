// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/frame_association.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "libhybrid/association/joint_compatibility.h"
#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/landmarks/contribution.h"

namespace hybrid {
namespace {

/// Landmarks that the detections of a frame may be, the nearest: their joint covariance costs the
/// square of that.
constexpr std::size_t kMostTracks = 40;
/// Matchings of a frame whose joint evidence is computed, those that are best pair by pair: more
/// than are kept open, as the order by joint evidence is another.
constexpr std::size_t kMostMatchings = 40;

/// Where detections fall in the map and how far off they may be.
struct Located {
  Eigen::Vector3d point;
  double sigma;                // along the longest axis of its covariance [m]
  Eigen::MatrixXd covariance;  // [m^2]
};

template <class Pose>
Located locate_one(const Pose& pose, const Pose& sensor, const Eigen::MatrixXd& covariance,
                   const MeasuredPoint& measured) {
  const auto at =
      locate<Pose>(pose, measured.z, Noise::covariance(measured.covariance), sensor, covariance);
  return {
      padded_point(at.mean),
      std::sqrt(at.covariance.template selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff()),
      at.covariance};
}

template <class Pose>
PredictedSightings predict(const Pose& pose, const Pose& sensor, const std::vector<Key>& keys,
                           const KeyframeView& frame, const MapView& map) {
  std::vector<typename Pose::Point> points;
  for (const Key key : keys) points.push_back(map.values.at<typename Pose::Point>(key));
  return predict_sightings_by(pose, sensor, points, [&](const Eigen::MatrixXd& J) {
    return keys.empty() ? Eigen::MatrixXd(0, 0) : frame.covariance_of(keys, J);
  });
}

/// The covariance of the robot's pose as seen from where this place was first looked at, in the
/// tangent of the robot; that in the map where nobody looked yet. How far the way to this place has
/// drifted says nothing about what was seen in it.
template <class Pose>
Eigen::MatrixXd local_covariance(const Pose& T_map_robot, const KeyframeView& frame,
                                 const FrameContext& context, const MapView& map) {
  const auto first = context.views.first_near(frame.T_map_robot.translation(),
                                              context.coverage.max_range, frame.pose, map);
  if (!first) return frame.joint_covariance({});
  return covariance_of_motion(frame, *first,
                              T_map_robot.between(map.values.at<Pose>(*first)).adjoint());
}

/// Each landmark is seen itself, or something about it.
void add_extents(const LandmarkTracks& landmarks, FrameCandidates& c) {
  const int dim = c.predicted.dim;
  for (std::size_t j = 0; j < c.tracks.size(); ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    const Eigen::Matrix3d noise =
        noise_of_extent(c.predicted.mean(0, column), dim == 3 ? c.predicted.mean(2, column) : 0,
                        landmarks.track(c.tracks[j]).extent, dim == 3);
    c.extents.push_back(noise.topLeftCorner(dim, dim));
    c.predicted.covariance.block(dim * column, dim * column, dim, dim) += c.extents.back();
  }
}

/// The noise of detection i as one of candidate j.
Eigen::MatrixXd noise_of(const FrameCandidates& c, std::size_t i, std::size_t j) {
  return c.measured[i].covariance + c.extents[j];
}

/// How far off landmark j is, seen from the robot [m].
double sigma_of(const PredictedSightings& predicted, Eigen::Index j) {
  const Eigen::VectorXd variances =
      predicted.covariance.diagonal().segment(predicted.dim * j, predicted.dim);
  const double range = predicted.mean(0, j);
  return std::sqrt(variances[0] + range * range * variances.tail(predicted.dim - 1).sum());
}

/// Landmarks that may be within the gate of some detection, nearest first where there are too many.
/// What is known less well than `spacing`, how far landmarks are apart, is told from no other.
std::vector<int> nearby_tracks(const std::vector<Located>& located, double gate_sigmas,
                               double spacing, const MapView& map,
                               const LandmarkTracks& landmarks) {
  std::vector<std::pair<double, int>> found;
  for (const Located& at : located) {
    const double sigma = std::min(at.sigma, spacing), coverage = gate_sigmas * sigma;
    landmarks.grid().visit_near(at.point.x(), at.point.y(), 2 * coverage, [&](int t) {
      const Track& track = landmarks.track(t);
      if (!track.alive || !map.holds(track.position)) return;
      const double own = std::min(track.sigma, spacing);
      const double d = (point_at(map.values, track.position) - at.point).norm();
      if (d <= coverage + gate_sigmas * own) found.emplace_back(d / (sigma + own + 1e-9), t);
    });
  }
  std::sort(found.begin(), found.end());
  std::vector<int> tracks;
  for (const auto& [distance, t] : found) {
    if (tracks.size() == kMostTracks) break;
    if (std::find(tracks.begin(), tracks.end(), t) == tracks.end()) tracks.push_back(t);
  }
  std::sort(tracks.begin(), tracks.end());
  return tracks;
}

/// The log of the volume that what is known shrinks by if detection i is matched with candidate j.
double information(const FrameCandidates& c, Eigen::Index i, Eigen::Index j) {
  const Eigen::Index at = c.predicted.dim * j;
  const Eigen::MatrixXd S = c.measured[i].covariance +
                            c.predicted.covariance.block(at, at, c.predicted.dim, c.predicted.dim);
  return 0.5 * std::log(S.determinant() / noise_of(c, i, j).determinant());
}

/// By detection, the share of landmarks that are undetected where it falls. Asked only where there
/// is a choice: with no candidate within the gate, what a new landmark costs decides nothing.
std::vector<double> undetected(const FrameCandidates& c, const std::vector<Located>& located,
                               const FrameContext& context, const MapView& map) {
  const AssociationOptions& options = context.options;
  const double gate = chi_square_quantile(options.gate, c.predicted.dim);
  const DetectionModel detections(
      context.coverage.detection_probability(options.detection_probability));
  std::vector<double> shares(located.size(), 1.0);
  for (std::size_t i = 0; i < located.size(); ++i) {
    bool choice = false;
    for (int j = 0; j < static_cast<int>(c.tracks.size()) && !choice; ++j) {
      choice = c.score(i, j).chi_square <= gate;
    }
    if (!choice) continue;
    shares[i] = context.views.undetected(located[i].point.head(c.predicted.dim),
                                         located[i].covariance, detections, map);
  }
  return shares;
}

/// A landmark of the last stretch may be matched by what it is worth. Of others only those that one
/// detection alone can tell: where the way back to them has drifted, places are recognised by many.
void fill_costs(const std::vector<std::vector<double>>& phi, const FrameContext& context,
                FrameCandidates& c) {
  const AssociationOptions& options = context.options;
  const LandmarkTracks& landmarks = context.landmarks;
  const auto rows = static_cast<Eigen::Index>(c.measured.size());
  const auto cols = static_cast<Eigen::Index>(c.tracks.size());
  const double volume = context.coverage.measurement_volume();
  const double landmarks_in_view = context.coverage.expected_in_view(options.landmarks_in_view);
  const double gate = chi_square_quantile(options.gate, c.predicted.dim);
  const std::vector<double> prior =
      context.classes.names().empty() ? std::vector<double>{} : context.classes.prior();
  c.problem.matched.setConstant(rows, cols, std::numeric_limits<double>::infinity());
  c.problem.unmatched.resize(rows);
  c.class_cost.setZero(rows, cols);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double density = (c.undetected[i] * landmarks_in_view + options.clutter_in_view) / volume;
    c.problem.unmatched[i] = -std::log(density) + class_cost(phi[i], prior);
  }
  for (Eigen::Index j = 0; j < cols; ++j) {
    const Track& track = landmarks.track(c.tracks[j]);
    const std::vector<double> belief =
        track.class_key ? landmarks.class_belief(track, context.classes) : std::vector<double>{};
    const bool recent = !(landmarks.last_seen_from(c.tracks[j]) < context.recent_since);
    for (Eigen::Index i = 0; i < rows; ++i) {
      c.class_cost(i, j) = class_cost(phi[i], belief);
      const GaussianScore& score = c.score(i, j);
      if (score.chi_square > gate) continue;
      const double cost = score.cost + c.class_cost(i, j);
      const double at_best = c.problem.unmatched[i] - cost + 0.5 * score.chi_square -
                             options.information_penalty * information(c, i, j);
      if (recent || at_best > std::log(options.old_landmark_odds)) c.problem.matched(i, j) = cost;
    }
  }
}

/// The log of the volume that what is known shrinks by if some detections are matched. A match
/// has to earn it: where the pose is known poorly, one that may be wrong costs more than a new
/// landmark, which can still be merged once several agree.
double information(const FrameCandidates& c, const Matching& matching) {
  std::vector<int> rows;
  for (std::size_t i = 0; i < c.measured.size(); ++i) {
    if (matching.column[i] >= 0) rows.push_back(static_cast<int>(i));
  }
  const int dim = c.predicted.dim, n = dim * static_cast<int>(rows.size());
  Eigen::MatrixXd S(n, n);
  double noise = 0;
  for (int a = 0; a < n / dim; ++a) {
    for (int b = 0; b < n / dim; ++b) {
      S.block(dim * a, dim * b, dim, dim) = c.predicted.covariance.block(
          dim * matching.column[rows[a]], dim * matching.column[rows[b]], dim, dim);
    }
    S.block(dim * a, dim * a, dim, dim) += c.measured[rows[a]].covariance;
    noise += std::log(noise_of(c, rows[a], matching.column[rows[a]]).determinant());
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(S);
  double sum = -0.5 * noise;
  for (int k = 0; k < n; ++k) sum += std::log(llt.matrixLLT()(k, k));
  return sum;
}

/// The evidence of a matching with all correlations, in place of the sum over its pairs.
double joint_cost(const FrameCandidates& c, const Matching& matching, double information_penalty) {
  double cost = 0;
  bool any = false;
  for (std::size_t i = 0; i < c.measured.size(); ++i) {
    const int j = matching.column[i];
    cost += j < 0 ? c.problem.unmatched[static_cast<Eigen::Index>(i)]
                  : c.class_cost(static_cast<Eigen::Index>(i), j);
    any = any || j >= 0;
  }
  if (!any) return cost;
  return cost + c.predicted.score(c.measured, matching).cost +
         information_penalty * information(c, matching);
}

FrameHypothesis as_hypothesis(const FrameCandidates& c, const Matching& matching,
                              double information_penalty) {
  FrameHypothesis out;
  out.cost = joint_cost(c, matching, information_penalty);
  for (std::size_t i = 0; i < c.measured.size(); ++i) {
    const int j = matching.column[i];
    out.track.push_back(j < 0 ? -1 : c.tracks[j]);
    if (j < 0) {
      out.constant.push_back(c.problem.unmatched[static_cast<Eigen::Index>(i)]);
      continue;
    }
    // The factor knows the noise R of the sensor alone, the evidence was under S = H P H' + R: the
    // difference of their normalisers is the Occam factor of the point estimate.
    out.constant.push_back(information(c, static_cast<Eigen::Index>(i), j));
  }
  return out;
}

std::vector<Matching> nearest(const FrameCandidates& c, double information_penalty) {
  Matching matching{std::vector<int>(c.measured.size(), -1), 0};
  for (std::size_t i = 0; i < c.measured.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    Eigen::Index j = 0;
    if (c.problem.matched.cols() == 0) continue;
    const double cost = c.problem.matched.row(row).minCoeff(&j);
    if (!std::isfinite(cost)) continue;
    Matching alone{std::vector<int>(c.measured.size(), -1), 0};
    alone.column[i] = static_cast<int>(j);
    if (cost + information_penalty * information(c, alone) < c.problem.unmatched[row]) {
      matching.column[i] = static_cast<int>(j);
    }
  }
  return {matching};
}

}  // namespace

FrameCandidates find_candidates(const KeyframeView& frame, const DetectionFrame& seen,
                                const std::vector<std::vector<double>>& phi, const MapView& map,
                                const FrameContext& context) {
  const AssociationOptions& options = context.options;
  const LandmarkTracks& landmarks = context.landmarks;
  FrameCandidates c;
  const int dim = map.is_3d ? 3 : 2;
  const double sigmas = std::sqrt(chi_square_quantile(options.gate, dim));
  const Eigen::MatrixXd local =
      map.is_3d ? local_covariance(to_se3(frame.T_map_robot), frame, context, map)
                : local_covariance(to_se2(frame.T_map_robot), frame, context, map);
  const double widest = *std::max_element(options.extent.begin(), options.extent.end());
  std::vector<Located> located;
  for (const Detection& d : seen.detections) {
    c.measured.push_back(measured_point(d, map.is_3d));
    const MeasuredPoint about = measured_point(with_extent(d, widest, map.is_3d), map.is_3d);
    located.push_back(
        map.is_3d
            ? locate_one(to_se3(frame.T_map_robot), to_se3(seen.T_robot_sensor), local, about)
            : locate_one(to_se2(frame.T_map_robot), to_se2(seen.T_robot_sensor), local, about));
  }
  const double density = context.coverage.density(options.landmarks_in_view);
  c.tracks = nearby_tracks(located, sigmas, std::pow(density, -1.0 / dim), map, landmarks);
  std::vector<Key> keys;
  for (int t : c.tracks) keys.push_back(landmarks.track(t).position);
  c.predicted =
      map.is_3d ? predict(to_se3(frame.T_map_robot), to_se3(seen.T_robot_sensor), keys, frame, map)
                : predict(to_se2(frame.T_map_robot), to_se2(seen.T_robot_sensor), keys, frame, map);
  const double drift = std::sqrt(frame.joint_covariance({}).topLeftCorner(dim, dim).trace());
  for (std::size_t j = 0; j < c.tracks.size(); ++j) {
    c.sigmas.push_back(drift + sigma_of(c.predicted, static_cast<Eigen::Index>(j)));
  }
  add_extents(landmarks, c);
  for (const MeasuredPoint& measured : c.measured) {
    for (std::size_t j = 0; j < c.tracks.size(); ++j) {
      c.scores.push_back(c.predicted.score(measured, static_cast<int>(j)));
    }
  }
  c.undetected = undetected(c, located, context, map);
  fill_costs(phi, context, c);
  return c;
}

void note_candidates(const FrameCandidates& candidates, const std::vector<int>& sightings,
                     const MapView& map, LandmarkTracks& landmarks) {
  for (std::size_t j = 0; j < candidates.tracks.size(); ++j) {
    landmarks.set(candidates.tracks[j], &Track::sigma, candidates.sigmas[j]);
    landmarks.place(candidates.tracks[j], map.values);
  }
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    landmarks.sighting(sightings[i]).undetected = candidates.undetected[i];
  }
}

std::vector<FrameHypothesis> find_hypotheses(const FrameCandidates& candidates,
                                             const AssociationOptions& options) {
  using Method = AssociationOptions::Method;
  std::vector<Matching> matchings;
  const double margin = std::log(options.keep_open_odds);
  if (options.method == Method::kNearest) {
    matchings = nearest(candidates, options.information_penalty);
  } else if (options.method == Method::kJcbb) {
    matchings = {joint_compatibility(candidates.predicted, candidates.measured, options.gate)};
  } else {
    matchings = k_best_matchings(candidates.problem, kMostMatchings, margin);
    matchings.push_back({std::vector<int>(candidates.measured.size(), -1), 0});
  }
  std::vector<FrameHypothesis> out;
  for (const Matching& matching : matchings) {
    FrameHypothesis hypothesis = as_hypothesis(candidates, matching, options.information_penalty);
    const bool known = std::any_of(out.begin(), out.end(), [&](const FrameHypothesis& other) {
      return other.track == hypothesis.track;
    });
    if (!known) out.push_back(std::move(hypothesis));
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return a.cost < b.cost; });
  const double limit = out.front().cost + margin;
  const auto far = std::find_if(out.begin(), out.end(),
                                [&](const FrameHypothesis& h) { return h.cost > limit; });
  out.erase(far, out.end());
  if (static_cast<int>(out.size()) > options.hypotheses) out.resize(options.hypotheses);
  return out;
}

}  // namespace hybrid
