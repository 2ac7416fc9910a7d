// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/initialization/direction_tracker.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "libhybrid/association/gate.h"
#include "libhybrid/association/matching.h"
#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/discrete/class_evidence.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/geometry/so2.h"
#include "libhybrid/geometry/so3.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostDirections = 40;  // of a track, a budget: then every second one goes
constexpr std::size_t kFewestDirections = 4;
constexpr std::size_t kMostUnseenFrames = 50;  // frames, where the log has no times
constexpr int kDirectionIterations = 10;
constexpr double kSmallDirectionStep = 1e-3;  // in sigmas
constexpr double kDirectionsFit =
    0.9999;                         // probability with which a thing at rest is taken for one
constexpr double kIdPrice = 1e3;    // -log odds of an id that is that of a track
constexpr double kNewInView = 0.3;  // directions of things not yet followed, expected in a frame

/// Direction and inverse range of a point, from the sensor as it stood then. The point is d / rho,
/// so that one at infinity is as good as any.
struct PredictedDirection {
  Eigen::Vector3d z;                      // yaw, pitch, inverse range
  Eigen::Matrix3d by_state;               // of the state (yaw, pitch, inverse range) now
  Eigen::Matrix<double, 3, 6> by_motion;  // of the motion since, perturbed from the right
};

PredictedDirection predict_direction(const Eigen::Isometry3d& T_then_now,
                                     const Eigen::Isometry3d& T_robot_sensor,
                                     const Eigen::Vector3d& state) {
  const double cy = std::cos(state[0]), sy = std::sin(state[0]);
  const double cp = std::cos(state[1]), sp = std::sin(state[1]), rho = state[2];
  const Eigen::Vector3d d(cp * cy, cp * sy, -sp);
  const Eigen::Matrix3d& S = T_robot_sensor.linear();
  const Eigen::Vector3d on_robot = S * d + rho * T_robot_sensor.translation();
  const Eigen::Matrix3d R = S.transpose() * T_then_now.linear();
  const Eigen::Vector3d moved = T_then_now.linear() * on_robot + rho * T_then_now.translation();
  const Eigen::Vector3d h = S.transpose() * (moved - rho * T_robot_sensor.translation());
  Eigen::Matrix3d h_by_state;
  h_by_state.col(0) = R * S * Eigen::Vector3d(-cp * sy, cp * cy, 0);
  h_by_state.col(1) = R * S * Eigen::Vector3d(-sp * cy, -sp * sy, -cp);
  h_by_state.col(2) = R * T_robot_sensor.translation() +
                      S.transpose() * (T_then_now.translation() - T_robot_sensor.translation());
  Eigen::Matrix<double, 3, 6> h_by_motion;
  h_by_motion << rho * R, -R * hat(on_robot);
  constexpr double kLeast = 1e-9;
  const double flat2 = std::max(h.head<2>().squaredNorm(), kLeast * kLeast);
  const double flat = std::sqrt(flat2), n2 = flat2 + h.z() * h.z(), n = std::sqrt(n2);
  Eigen::Matrix3d by_h;
  by_h << -h.y() / flat2, h.x() / flat2, 0,                                  //
      h.z() * h.x() / (flat * n2), h.z() * h.y() / (flat * n2), -flat / n2,  //
      -rho * h.x() / (n2 * n), -rho * h.y() / (n2 * n), -rho * h.z() / (n2 * n);
  PredictedDirection out;
  out.z << std::atan2(h.y(), h.x()), -std::atan2(h.z(), flat), rho / n;
  out.by_state = by_h * h_by_state;
  out.by_state(2, 2) += 1 / n;
  out.by_motion = by_h * h_by_motion;
  return out;
}

/// The rows of (yaw, pitch, inverse range) that something says.
std::vector<int> direction_rows(bool direction, bool inverse_range, bool is_3d) {
  std::vector<int> rows;
  if (direction) rows.push_back(0);
  if (direction && is_3d) rows.push_back(1);
  if (inverse_range) rows.push_back(2);
  return rows;
}

}  // namespace

void DirectionTracker::move(const Eigen::Isometry3d& motion, const SE3::Jacobian& covariance) {
  const Eigen::Isometry3d back = between(motion, Eigen::Isometry3d::Identity());
  const SE3::Jacobian Ad = adjoint(back);
  for (auto& [number, instant] : instants_) {
    instant.T_then_now = compose(instant.T_then_now, motion);
    instant.covariance = Ad * instant.covariance * Ad.transpose() + covariance;
  }
  for (auto& [label, sensor] : sensors_) {
    for (Track& track : sensor.tracks) {
      track.state = predict_direction(back, sensor.frame.T_robot_sensor, track.state).z;
    }
  }
  ++now_;
}

/// Of part `p` of one measurement and part `q` of another, by the noise of the sensor alone.
double DirectionTracker::own_covariance(const Measurement& a, int p, const Measurement& b,
                                        int q) const {
  if (&a == &b) return a.covariance(p, q);
  if (p != q || p == 2) return 0;
  return options_.common * std::sqrt(a.covariance(p, p) * b.covariance(q, q));
}

/// Least squares over measurements whose errors depend on one another through the motion that they
/// share: what comes between an instant and now is part of both where another instant is earlier.
std::optional<DirectionTracker::Fit> DirectionTracker::fit(const Sensor& sensor,
                                                           const std::vector<Measurement>& all,
                                                           const Eigen::Vector3d& start) const {
  const bool is_3d = sensor.frame.is_3d;
  const std::vector<int> dims = direction_rows(true, true, is_3d);
  const auto d = static_cast<Eigen::Index>(dims.size());
  struct Row {
    const Measurement* of;
    int part;
  };
  std::vector<Row> rows;
  for (const Measurement& m : all) {
    for (const int part : direction_rows(m.has_direction, m.has_inverse_range, is_3d)) {
      rows.push_back({&m, part});
    }
  }
  const auto n = static_cast<Eigen::Index>(rows.size());
  if (n < d) return std::nullopt;
  Fit out{start};
  Eigen::MatrixXd C(n, n), J(n, d), M(n, 6);
  Eigen::VectorXd r(n);
  for (int iteration = 0; iteration < kDirectionIterations; ++iteration) {
    PredictedDirection p;
    for (Eigen::Index i = 0; i < n; ++i) {
      const Row& row = rows[static_cast<std::size_t>(i)];
      if (i == 0 || rows[static_cast<std::size_t>(i - 1)].of != row.of) {
        p = predict_direction(instants_.at(row.of->instant).T_then_now, sensor.frame.T_robot_sensor,
                              out.state);
      }
      const double e = p.z[row.part] - row.of->z[row.part];
      r[i] = row.part == 2 ? e : wrap_angle(e);
      for (Eigen::Index k = 0; k < d; ++k) J(i, k) = p.by_state(row.part, dims[k]);
      M.row(i) = p.by_motion.row(row.part);
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      const Row& a = rows[static_cast<std::size_t>(i)];
      for (Eigen::Index j = 0; j <= i; ++j) {
        const Row& b = rows[static_cast<std::size_t>(j)];
        const std::size_t later = std::max(a.of->instant, b.of->instant);
        const double by_motion = M.row(i) * instants_.at(later).covariance * M.row(j).transpose();
        C(i, j) = C(j, i) = by_motion + own_covariance(*a.of, a.part, *b.of, b.part);
      }
    }
    const Eigen::LLT<Eigen::MatrixXd> llt(C);
    if (llt.info() != Eigen::Success || !r.allFinite()) return std::nullopt;
    const Eigen::MatrixXd WJ = llt.solve(J);
    const Eigen::LLT<Eigen::MatrixXd> normal(J.transpose() * WJ);
    if (normal.info() != Eigen::Success) return std::nullopt;
    const Eigen::VectorXd step = -normal.solve(WJ.transpose() * r);
    const Eigen::MatrixXd P = normal.solve(Eigen::MatrixXd::Identity(d, d));
    if (!step.allFinite() || !P.allFinite()) return std::nullopt;
    for (Eigen::Index k = 0; k < d; ++k) {
      out.state[dims[k]] += step[k];
      for (Eigen::Index l = 0; l < d; ++l) out.covariance(dims[k], dims[l]) = P(k, l);
    }
    out.state[0] = wrap_angle(out.state[0]);
    out.chi_square = r.dot(llt.solve(r)) + step.dot(WJ.transpose() * r);
    out.redundancy = static_cast<int>(n - d);
    if (step.dot(J.transpose() * WJ * step) < kSmallDirectionStep * kSmallDirectionStep) return out;
  }
  return std::nullopt;
}

void DirectionTracker::update(const Sensor& sensor, Track& track) const {
  std::vector<Measurement> all = track.prior;
  all.insert(all.end(), track.seen.begin(), track.seen.end());
  if (const auto found = fit(sensor, all, track.state)) {
    track.state = found->state;
    track.covariance = found->covariance;
  }
}

/// What the directions that were not handed on yet tell by themselves; none while that is too
/// little.
std::optional<DirectionTracker::Fit> DirectionTracker::range_of(const Sensor& sensor,
                                                                const Track& track) const {
  if (track.seen.size() < kFewestDirections) return std::nullopt;
  auto found = fit(sensor, track.seen, track.state);
  if (!found || !(found->state[2] > 0)) return std::nullopt;
  const double sigma = std::sqrt(found->covariance(2, 2));
  if (!(sigma <= options_.range_sigma * found->state[2])) return std::nullopt;
  return found;
}

/// The track that each direction continues, -1 for none.
std::vector<int> DirectionTracker::match(const Sensor& sensor, const DetectionFrame& frame) const {
  const auto rows = static_cast<Eigen::Index>(frame.detections.size());
  const auto cols = static_cast<Eigen::Index>(sensor.tracks.size());
  const Eigen::Index dim = frame.is_3d ? 2 : 1;
  const double space =
      (frame.fov_yaw > 0 ? frame.fov_yaw : 2 * M_PI) * (!frame.is_3d          ? 1
                                                        : frame.fov_pitch > 0 ? frame.fov_pitch
                                                                              : M_PI);
  MatchingProblem problem;
  problem.matched.setConstant(rows, cols, kInfinity);
  problem.unmatched.setConstant(rows, -std::log(kNewInView / space));
  for (Eigen::Index j = 0; j < cols; ++j) {
    const Track& track = sensor.tracks[static_cast<std::size_t>(j)];
    const Eigen::MatrixXd P = track.covariance.topLeftCorner(dim, dim);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const Detection& d = frame.detections[static_cast<std::size_t>(i)];
      if (d.id != track.id) continue;
      const Eigen::Vector2d e(wrap_angle(d.yaw - track.state[0]), d.pitch - track.state[1]);
      const GaussianScore score =
          gaussian_score(e.head(dim), P + d.covariance.block(1, 1, dim, dim));
      const double most = chi_square_quantile(options_.gate, static_cast<int>(dim));
      if (!(score.chi_square <= most)) continue;
      problem.matched(i, j) =
          score.cost + class_disagreement(d.class_probabilities, track.evidence);
      if (d.id) problem.matched(i, j) = -kIdPrice;
    }
  }
  return best_matching(problem).column;
}

void DirectionTracker::extend(const Sensor& sensor, Track& track, const Detection& detection) {
  Measurement seen;
  seen.instant = now_;
  seen.z << detection.yaw, detection.pitch, 0;
  seen.covariance.setZero();
  seen.covariance.topLeftCorner<2, 2>() = detection.covariance.bottomRightCorner<2, 2>();
  track.seen.push_back(seen);
  if (track.seen.size() > kMostDirections) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < track.seen.size(); i += 2) track.seen[kept++] = track.seen[i];
    track.seen.resize(kept);
  }
  track.members.push_back(detection.true_id);
  track.last_time = sensor.frame.time;
  track.last_instant = now_;
  add_class_scores(detection.class_probabilities, track.evidence);
  add_class_scores(detection.class_probabilities, track.evidence_seen);
}

/// Nothing but its direction is known of a new thing: the prior of its inverse range is a Gaussian
/// that holds all from the least depth to infinity within two sigmas.
void DirectionTracker::begin(Sensor& sensor, const Detection& detection) {
  Track track;
  track.id = detection.id;
  track.state << detection.yaw, detection.pitch, 0.5 / options_.least_depth;
  Measurement prior;
  prior.instant = now_;
  prior.z = track.state;
  prior.covariance.setZero();
  prior.covariance(2, 2) = std::pow(0.25 / options_.least_depth, 2);
  prior.has_direction = false;
  prior.has_inverse_range = true;
  track.prior = {prior};
  sensor.tracks.push_back(std::move(track));
}

bool DirectionTracker::is_old(const Sensor& sensor, const Track& track) const {
  if (sensor.frame.time == 0) return now_ - track.last_instant > kMostUnseenFrames;
  return sensor.frame.time - track.last_time > options_.memory;
}

void DirectionTracker::take(const DetectionFrame& frame) {
  Sensor& sensor = sensors_[frame.sensor_label];
  sensor.frame = frame;
  sensor.frame.detections.clear();
  instants_[now_];
  std::vector<Track>& tracks = sensor.tracks;
  tracks.erase(std::remove_if(tracks.begin(), tracks.end(),
                              [&](const Track& track) {
                                return is_old(sensor, track) && !range_of(sensor, track);
                              }),
               tracks.end());
  for (Track& track : tracks) update(sensor, track);
  const std::vector<int> column = match(sensor, frame);
  for (std::size_t i = 0; i < frame.detections.size(); ++i) {
    if (column[i] < 0) begin(sensor, frame.detections[i]);
    Track& track = column[i] < 0 ? tracks.back() : tracks[static_cast<std::size_t>(column[i])];
    extend(sensor, track, frame.detections[i]);
    update(sensor, track);
    ++taken_;
  }
  prune();
}

/// Forgets instants that nothing is measured at.
void DirectionTracker::prune() {
  std::set<std::size_t> used{now_};
  for (const auto& [label, sensor] : sensors_) {
    for (const Track& track : sensor.tracks) {
      for (const Measurement& m : track.prior) used.insert(m.instant);
      for (const Measurement& m : track.seen) used.insert(m.instant);
    }
  }
  for (auto it = instants_.begin(); it != instants_.end();) {
    it = used.count(it->first) != 0 ? std::next(it) : instants_.erase(it);
  }
}

Detection DirectionTracker::detection_of(const Track& track, const Fit& fit) const {
  Detection out;
  out.id = track.id;
  out.members = track.members;
  out.range = 1 / fit.state[2];
  out.yaw = fit.state[0];
  out.pitch = fit.state[1];
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();  // (range, yaw, pitch) of (yaw, pitch, 1 / range)
  J(0, 2) = -out.range * out.range;
  J(1, 0) = J(2, 1) = 1;
  out.covariance = J * fit.covariance * J.transpose();
  out.at_rest = track.id.has_value() ||
                fit.chi_square <= chi_square_quantile(kDirectionsFit, std::max(fit.redundancy, 1));
  const auto n = static_cast<double>(track.members.size());
  const double inflation = 1 - options_.common + options_.common * n;
  out.class_probabilities = class_probabilities(track.evidence_seen, inflation);
  return out;
}

std::vector<DetectionFrame> DirectionTracker::release() {
  std::vector<DetectionFrame> out;
  for (auto& [label, sensor] : sensors_) {
    DetectionFrame frame = sensor.frame;
    frame.has_range = true;
    frame.min_range = frame.max_range = 0;
    for (Track& track : sensor.tracks) {
      const auto known = range_of(sensor, track);
      if (!known) continue;
      frame.detections.push_back(detection_of(track, *known));
      released_ += track.members.size();
      update(sensor, track);
      Measurement before;
      before.instant = now_;
      before.z = track.state;
      before.covariance = track.covariance;
      before.has_inverse_range = true;
      track.prior = {before};
      track.seen.clear();
      track.members.clear();
      track.evidence_seen.clear();
    }
    if (!frame.detections.empty()) out.push_back(std::move(frame));
  }
  if (!out.empty()) instants_[now_];
  prune();
  return out;
}

std::size_t DirectionTracker::followed() const {
  std::size_t count = 0;
  for (const auto& [label, sensor] : sensors_) count += sensor.tracks.size();
  return count;
}

}  // namespace hybrid
