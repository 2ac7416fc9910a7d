// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/error.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/quantile.h"
#include "libhybrid/geometry/isometry.h"
#include "mrpt_plugins/health/detail/run_facts.h"

namespace hybrid {
namespace {

constexpr std::size_t kLongestStretch = 64, kFewestStretches = 8, kMostStretches = 64;
constexpr double kLeastRedundancyOfPath = 5;
/// The factor by which sigmas of odometry are wrong.
constexpr double kOdometryDoubtful = 1.5, kOdometryBad = 2;
constexpr UpperLimits kScaleLimits{1.5, 2};  // of an estimated scale: no wheel is worn so far
constexpr double kOdometryExcess = 4;
constexpr double kSureOfPath = 0.9999;  // probability at which something is not by chance
constexpr int kBlocks = 20;             // left out in turn, for the sigma of the delay
constexpr double kLeastDelay = 0.1;     // of the time between keyframes

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Odometry from one pose to another, several keyframes on.
struct Stretch {
  std::size_t from = 0, to = 0;
  Eigen::Isometry3d measured = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();
  // Of the steps that are longer than their noise, summed [m]:
  double way = 0, noise = 0;
};

std::optional<Stretch> stretch_from(const RunFacts& facts, std::size_t from, std::size_t length) {
  Stretch out{from, from};
  for (std::size_t i = 0; i < length; ++i) {
    const auto next = facts.motions.find(out.to);
    if (next == facts.motions.end()) return std::nullopt;
    const FactOfMotion& motion = next->second;
    const Matrix6d Ad = adjoint(Eigen::Isometry3d(motion.measured.inverse()));
    out.measured = out.measured * motion.measured;
    out.covariance = Ad * out.covariance * Ad.transpose() + motion.covariance;
    out.to = motion.to;
    const double step = motion.measured.translation().norm();
    const double noise = std::sqrt(motion.covariance.topLeftCorner<3, 3>().trace());
    if (step < noise) continue;
    out.way += step;
    out.noise += noise;
  }
  return out;
}

Vector6d tangent_of(const Eigen::Isometry3d& T) {
  const Eigen::AngleAxisd turn(T.rotation());
  Vector6d out;
  out << T.translation(), turn.angle() * turn.axis();
  return out;
}

/// The entries that a map of this dimension has.
Eigen::MatrixXd own_part(const Matrix6d& M, bool is_3d) {
  return is_3d ? Eigen::MatrixXd(M) : Eigen::MatrixXd(planar_part(M));
}
Eigen::VectorXd own_part(const Vector6d& v, bool is_3d) {
  if (is_3d) return v;
  return Eigen::Vector3d(v[kPlanarIndices[0]], v[kPlanarIndices[1]], v[kPlanarIndices[2]]);
}

/// Covariance of the estimated motion over a stretch.
Eigen::MatrixXd estimated_covariance(const RunFacts& facts, const Stretch& stretch,
                                     const Eigen::Isometry3d& T) {
  const Key a(key_letter::kPose, stretch.from), b(key_letter::kPose, stretch.to);
  const Eigen::MatrixXd P = facts.marginals->joint_covariance({a, b});
  const Matrix6d Ad = adjoint(Eigen::Isometry3d(T.inverse()));
  const Eigen::MatrixXd A = own_part(Ad, facts.run.result.is_3d);
  Eigen::MatrixXd J(A.rows(), 2 * A.rows());
  J << -A, Eigen::MatrixXd::Identity(A.rows(), A.rows());
  return J * P * J.transpose();
}

/// How far the path is from the odometry over stretches, in squared sigmas, and how far it should
/// be, since other measurements tell as much of it.
struct Correction {
  double sum = 0, redundancy = 0;
  double way = 0, noise = 0;  // of stretches, summed
  std::size_t stretches = 0, length = 0;

  /// Whether noise that is larger by this factor would still leave something that odometry tells.
  bool may_be_noise(double factor) const { return way == 0 || factor * noise < way; }
};

void add_stretch(const RunFacts& facts, const Stretch& stretch, Correction& out) {
  const bool is_3d = facts.run.result.is_3d;
  const Eigen::Isometry3d T = between(facts.pose(stretch.from), facts.pose(stretch.to));
  const Eigen::VectorXd e = own_part(tangent_of(between(stretch.measured, T)), is_3d);
  const Eigen::LDLT<Eigen::MatrixXd> stated(own_part(stretch.covariance, is_3d));
  const double own = stated.solve(estimated_covariance(facts, stretch, T)).trace();
  const auto dim = static_cast<double>(e.size());
  const double squared = e.dot(stated.solve(e));
  if (!std::isfinite(squared) || !std::isfinite(own)) return;
  out.sum += squared;
  out.redundancy += std::clamp(dim - own, 0.0, dim);
  out.way += stretch.way;
  out.noise += stretch.noise;
  ++out.stretches;
}

Correction correction_of(const RunFacts& facts) {
  Correction out;
  const std::vector<std::size_t> poses(facts.in_graph.begin(), facts.in_graph.end());
  const std::size_t count = poses.size();
  out.length = std::clamp<std::size_t>(count / kFewestStretches, 1, kLongestStretch);
  const std::size_t step =
      std::max<std::size_t>(std::max<std::size_t>(1, out.length / 2), count / kMostStretches);
  for (std::size_t from = 0; from + out.length < count; from += step) {
    const auto stretch = stretch_from(facts, poses[from], out.length);
    if (!stretch) continue;
    try {
      add_stretch(facts, *stretch, out);
    } catch (const Error&) {
      // poses that have left the window
    }
  }
  return out;
}

const char* knob_of(bool departs, bool by_scans) {
  if (by_scans) return "pose and field of view of the laser, time stamps of scans and odometry";
  return departs ? "noise of the odometry: larger (hybrid-import csv --walk-translation, "
                   "--walk-rotation; [reader] odometry_sigma_m, odometry_sigma_deg); its scale "
                   "and drift ([calibration] odometry); sign, pose and clock of the sensor"
                 : "noise of the odometry: smaller (hybrid-import csv --walk-translation, "
                   "--walk-rotation; [reader] odometry_sigma_m, odometry_sigma_deg)";
}

HealthEntry entry_on(const Correction& correction, const RunFacts& facts) {
  HealthEntry entry;
  entry.name = "path against odometry";
  entry.value = std::sqrt(correction.sum / correction.redundancy);
  entry.least = 1 / kOdometryExcess;
  entry.most = kOdometryDoubtful;
  const double excess = 1 / entry.value;
  if (entry.value > 1) {
    entry.verdict = judge(entry.value, {kOdometryDoubtful, kOdometryBad});
  } else if (excess > kOdometryExcess && facts.figure("clouds") == 0) {
    // Clouds tell so much more than odometry that nothing follows from noise that is stated too
    // large.
    entry.verdict = facts.run.associates() ? HealthVerdict::kBad : HealthVerdict::kDoubtful;
  }
  // The fault is of the odometry then, and a path by scans does not follow it.
  if (facts.is_by_scans() && facts.run.agrees) {
    entry.verdict = std::min(entry.verdict, HealthVerdict::kDoubtful);
  }
  entry.sentence = fmt::format(
      "Over {} keyframes the path departs from the odometry by {:.2g} times what the noise of both "
      "allows.",
      correction.length, entry.value);
  if (entry.verdict != HealthVerdict::kGood) {
    entry.knob = knob_of(entry.value > 1, facts.is_by_scans());
  }
  // Scans measure the noise; clouds tell so much that odometry of another drive seems all noise.
  const bool is_noise = facts.figure("clouds") == 0 || correction.may_be_noise(entry.value);
  if (!facts.is_by_scans() && is_noise) {
    entry.scale = "reader.odometry_sigma_factor";
  }
  return entry;
}

/// A slope of one line through the origin of two centred lists.
double slope_of(const std::vector<double>& x, const std::vector<double>& y, std::size_t skip_from,
                std::size_t skip_to) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (i >= skip_from && i < skip_to) continue;
    n += 1;
    sx += x[i];
    sy += y[i];
    sxx += x[i] * x[i];
    sxy += x[i] * y[i];
  }
  return (sxy - sx * sy / n) / (sxx - sx * sx / n);
}

/// A slope with the sigma of the jackknife over blocks of time.
struct Slope {
  double value = 0, sigma = 0;
  double squared() const { return value * value / (sigma * sigma); }
};

Slope slope_of(const std::vector<double>& x, const std::vector<double>& y) {
  Slope out{slope_of(x, y, 0, 0), 0};
  std::vector<double> parts;
  double mean = 0;
  for (int b = 0; b < kBlocks; ++b) {
    const std::size_t from = x.size() * b / kBlocks, to = x.size() * (b + 1) / kBlocks;
    parts.push_back(slope_of(x, y, from, to));
    mean += parts.back() / kBlocks;
  }
  for (const double part : parts) out.sigma += (part - mean) * (part - mean);
  out.sigma = std::sqrt(out.sigma * (kBlocks - 1) / kBlocks);
  return out;
}

/// What a late clock does: the estimated motion is the odometry of some time before.
struct ClockFit {
  std::vector<double> turn_change, turn_error, speed_change, speed_error;
  std::vector<double> intervals;
};

/// Measured motions between poses at which the sensor in question looked, by where they begin.
std::map<std::size_t, FactOfMotion> motions_of_sensor(const RunFacts& facts) {
  if (facts.sightings.empty()) return facts.motions;
  std::map<std::size_t, FactOfMotion> out;
  for (const std::size_t from : facts.looked_from) {
    Eigen::Isometry3d measured = Eigen::Isometry3d::Identity();
    for (auto next = facts.motions.find(from); next != facts.motions.end();
         next = facts.motions.find(next->second.to)) {
      measured = measured * next->second.measured;
      if (facts.looked_from.count(next->second.to) == 0) continue;
      out[from] = {next->second.to, measured, {}};
      break;
    }
  }
  return out;
}

ClockFit clock_fit(const RunFacts& facts) {
  ClockFit out;
  const Trajectory& path = facts.run.result.trajectory;
  const std::map<std::size_t, FactOfMotion> motions = motions_of_sensor(facts);
  const auto rates = [&](std::size_t i) -> std::optional<std::array<double, 3>> {
    const auto m = motions.find(i);
    if (m == motions.end() || m->second.to >= path.size()) return std::nullopt;
    const double dt = path[m->second.to].time - path[i].time;
    if (dt <= 0) return std::nullopt;
    const Vector6d v = tangent_of(m->second.measured);
    return std::array<double, 3>{v[5] / dt, v[0] / dt, dt};
  };
  std::optional<std::size_t> before;
  for (const auto& [i, motion] : motions) {
    const auto here = rates(i), after = rates(motion.to);
    const auto earlier = before ? rates(*before) : std::nullopt;
    const bool follows = before && motions.at(*before).to == i;
    before = i;
    if (!here || !after || !earlier || !follows) continue;
    const Vector6d e =
        tangent_of(between(motion.measured, between(facts.pose(i), facts.pose(motion.to))));
    out.turn_change.push_back(((*after)[0] - (*earlier)[0]) / 2);
    out.turn_error.push_back(e[5]);
    out.speed_change.push_back(((*after)[1] - (*earlier)[1]) / 2);
    out.speed_error.push_back(e[0]);
    out.intervals.push_back((*here)[2]);
  }
  return out;
}

void check_clock(const RunFacts& facts, Health& health) {
  const ClockFit fit = clock_fit(facts);
  if (fit.intervals.size() < 5 * kBlocks) return;
  const Slope turn = slope_of(fit.turn_change, fit.turn_error);
  const Slope speed = slope_of(fit.speed_change, fit.speed_error);
  // Positive where the detections are stamped late: then the path lags behind the odometry.
  double squared = 0, delay = 0, weight = 0;
  int tests = 0;
  for (const Slope& slope : {turn, speed}) {
    if (!std::isfinite(slope.value) || !(slope.sigma > 0)) continue;
    ++tests;
    squared += slope.squared();
    delay -= slope.value / (slope.sigma * slope.sigma);
    weight += 1 / (slope.sigma * slope.sigma);
  }
  if (tests == 0) return;
  delay /= weight;
  const double least = kLeastDelay * median(fit.intervals);
  HealthEntry entry;
  const bool by_scans = facts.is_by_scans();
  const char* sensor = by_scans ? "scans" : "detections";
  entry.name = fmt::format("clock of the {}", sensor);
  entry.value = delay;
  entry.least = -least;
  entry.most = least;
  const bool is_sure = squared > chi_square_quantile(kSureOfPath, tests);
  // A path by scans does not follow an odometry that has another clock.
  if (is_sure && std::abs(delay) > least) {
    entry.verdict = by_scans ? HealthVerdict::kDoubtful : HealthVerdict::kBad;
  }
  entry.sentence = entry.verdict == HealthVerdict::kGood
                       ? "The path turns and speeds up when the odometry does."
                       : fmt::format(
                             "The path turns and speeds up {} the odometry, by {:.2g} s or "
                             "more: the {} have stamps of another time.",
                             delay > 0 ? "later than" : "before", std::abs(delay), sensor);
  if (entry.verdict != HealthVerdict::kGood) {
    entry.knob = by_scans ? "time stamps of scans and odometry"
                          : "time stamps of the detections; bearings of the other sign do the same";
  }
  health.push_back(std::move(entry));
}

/// Whether a scale is that of lengths beside ranges of detections: either of both may have it.
bool is_of_ranges(const CalibrationEstimate::Entry& scale, const RunFacts& facts) {
  return scale.name == "scale of translation" && !facts.is_by_scans();
}

/// What is wrong with the scale of an odometry. A map that agrees over time has the lengths of its
/// ranges, whatever the odometry says: only where it says another unit that map is bad.
HealthVerdict judge_scale(const CalibrationEstimate::Entry& scale, double off,
                          const RunFacts& facts) {
  if (is_of_ranges(scale, facts) && facts.run.agrees &&
      judge(off, kScaleLimits) < HealthVerdict::kBad)
    return std::min(judge(off, kWheelLimits), HealthVerdict::kDoubtful);
  return judge(off,
               is_of_ranges(scale, facts) || facts.is_by_scans() ? kWheelLimits : kScaleLimits);
}

/// Noise of odometry that is stated too small looks like a scale and a drift, but like no wheel's.
void check_calibration(const RunFacts& facts, Health& health) {
  for (const CalibrationEstimate& calibration : facts.run.result.calibration) {
    for (const CalibrationEstimate::Entry& scale : calibration.entries) {
      if (scale.name.rfind("scale of ", 0) != 0 || !scale.observed) continue;
      HealthEntry entry;
      entry.name = scale.name + " of " + calibration.name;
      entry.is_optional = true;
      entry.value = factor_off(scale.value);
      const bool is_wheel = is_of_ranges(scale, facts) || facts.is_by_scans();
      entry.most = (is_wheel ? kWheelLimits : kScaleLimits).doubtful;
      entry.verdict = judge_scale(scale, entry.value, facts);
      entry.sentence = fmt::format("The {} is estimated at {:.3g}, which should be near 1.",
                                   scale.name, scale.value);
      if (entry.verdict == HealthVerdict::kGood) {
        health.push_back(std::move(entry));
        continue;
      }
      entry.knob =
          "units and noise of the odometry: what is noise looks like a scale where it is stated "
          "too small";
      if (is_of_ranges(scale, facts)) {
        entry.sentence += fmt::format(
            " Either ranges or odometry are {:.2g} % off; the map has the lengths of the ranges.",
            100 * (entry.value - 1));
        entry.knob += "; the scale of the ranges";
      }
      health.push_back(std::move(entry));
    }
  }
}

/// A log without any odometry is one of a sensor that tells the motion.
void check_missing(const RunFacts& facts, Health& health) {
  const auto missing = facts.run.dropped.find(kOdometryMissing);
  if (missing == facts.run.dropped.end()) return;
  if (2 * missing->second > facts.run.result.trajectory.size()) return;
  HealthEntry entry;
  entry.name = "motion that is not known";
  entry.value = static_cast<double>(missing->second);
  entry.verdict = facts.run.agrees ? HealthVerdict::kGood : HealthVerdict::kDoubtful;
  entry.sentence = fmt::format(
      "The odometry tells no motion to {} keyframes, as where it starts anew or is missing.",
      missing->second);
  entry.most = facts.run.agrees ? kInfinity : 0;
  if (entry.verdict != HealthVerdict::kGood) {
    entry.knob = "whether the robot was where the path continues, or had been carried there";
  }
  health.push_back(std::move(entry));
}

}  // namespace

void check_path(const RunFacts& facts, Health& health) {
  check_calibration(facts, health);
  check_missing(facts, health);
  if (!facts.marginals) return;
  const Correction correction = correction_of(facts);
  if (correction.stretches >= kFewestStretches && correction.redundancy > kLeastRedundancyOfPath) {
    health.push_back(entry_on(correction, facts));
  }
  if (facts.run.result.robots.size() < 2) check_clock(facts, health);
}

}  // namespace hybrid
