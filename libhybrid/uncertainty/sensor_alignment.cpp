// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/sensor_alignment.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "libhybrid/core/quantile.h"
#include "libhybrid/geometry/so2.h"
#include "libhybrid/uncertainty/detail/alignment_cost.h"

namespace hybrid {
namespace {

constexpr double kLongestDelay = 1;                                 // s
constexpr double kAlignmentSigmas = 3;                              // standard deviations
constexpr double kCoarseComparisons = 4e3, kFineComparisons = 4e4;  // of detections, for one cost
constexpr int kYaws = 36;                                           // of the whole circle
constexpr double kYawStep = M_PI / 90;  // rad, the most in one refinement
constexpr double kDelayStep = 0.1;      // s, the same
constexpr int kRefinements = 15;
constexpr double kFewestStretches = 5;
constexpr std::size_t kFewestFramePairs = 50, kFewestUsed = 10;  // pairs of frames
constexpr double kLeastDeterminant = 1e-6;  // of correlations, to be told apart
constexpr double kLeastShift = 0.05;        // m, of motion between frames that tells of mountings
constexpr double kLeastTurn = 0.02;         // rad, that tells of signs

/// Standard deviations by which another unit fits better. Of eight that are asked none may do so by
/// chance.
constexpr double kUnitSigmas = 5;

/// All signs and yaws, as if there was no delay.
std::vector<AlignmentChange> mountings(double length) {
  std::vector<AlignmentChange> out;
  for (const bool mirrored : {false, true}) {
    for (int i = 0; i < kYaws; ++i) {
      out.push_back({mirrored, wrap_angle(2 * M_PI * i / kYaws), 0, 0, length});
    }
  }
  return out;
}

/// The least scale of distances over signs and yaws: half the pairs agree so well.
double least_scale(const AlignmentCost& cost, double length = 1) {
  double scale = std::numeric_limits<double>::infinity();
  for (const AlignmentChange& change : mountings(length)) {
    scale = std::min(scale, median_of_all(cost.distances(change)));
  }
  return scale;
}

/// The best of many, of which the first is kept among equals.
AlignmentChange best_of(const AlignmentCost& cost, double scale,
                        const std::vector<AlignmentChange>& tried) {
  AlignmentChange best = tried.front();
  double least = std::numeric_limits<double>::infinity();
  for (const AlignmentChange& change : tried) {
    const double sum = cost.costs(change, scale).sum();
    if (sum < least) {
      least = sum;
      best = change;
    }
  }
  return best;
}

/// The best yaw for a sign, as if there was no delay.
AlignmentChange search_yaw(const AlignmentCost& cost, double scale, bool mirrored) {
  std::vector<AlignmentChange> tried = mountings(1);
  tried.erase(
      std::remove_if(tried.begin(), tried.end(),
                     [&](const AlignmentChange& change) { return change.mirrored != mirrored; }),
      tried.end());
  return best_of(cost, scale, tried);
}

/// The best delay of all, and the yaw that goes with it, which are sought together: on a curve a
/// delay looks like a yaw.
AlignmentChange search_delay(const AlignmentCost& cost, double scale, const AlignmentChange& best) {
  std::vector<AlignmentChange> tried = {best};
  for (int i = -6; i <= 6; ++i) {
    for (int j = -8; j <= 8; ++j) {
      tried.push_back(
          {best.mirrored, wrap_angle(best.yaw + 2 * kYawStep * i), kLongestDelay * j / 8.0, 0});
    }
  }
  return best_of(cost, scale, tried);
}

/// A step of yaw, delay and drift that brings the cost down by its normal equations, over the drift
/// and those of yaw and delay that are free; nothing where they tell of none.
std::optional<Eigen::Vector3d> step_of(Eigen::Matrix3d H, Eigen::Vector3d g, bool yaw, bool delay) {
  const bool free[] = {yaw, delay, true};
  for (int i = 0; i < 3; ++i) {
    if (free[i]) continue;
    H.row(i).setZero();
    H.col(i).setZero();
    H(i, i) = 1;
    g[i] = 0;
  }
  if (!(H.diagonal().minCoeff() > 0)) return std::nullopt;
  const Eigen::Vector3d unit = H.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix3d scaled = unit.asDiagonal() * H * unit.asDiagonal();
  if (!(scaled.determinant() > kLeastDeterminant)) return std::nullopt;
  const Eigen::Vector3d whitened = unit.cwiseProduct(g);
  return Eigen::Vector3d(-unit.cwiseProduct(scaled.inverse() * whitened));
}

/// Standard deviations are those with weights as they are, by which what is significant is told,
/// and true ones: the weights follow what they weigh.
struct Refined {
  AlignmentChange change;
  double yaw_sigma = std::numeric_limits<double>::infinity();
  double delay_sigma = std::numeric_limits<double>::infinity();
  double true_yaw_sigma = yaw_sigma, true_delay_sigma = delay_sigma;
};

/// Standard deviations of yaw, delay and drift at the least of the cost, by the jackknife; infinite
/// where a part of the log is needed to tell.
Eigen::Vector3d jackknife_spread(const std::array<AlignmentSystem, kAlignmentParts>& parts,
                                 const AlignmentSystem& all, Eigen::Matrix3d AlignmentSystem::*H,
                                 bool yaw, bool delay) {
  Eigen::Matrix<double, kAlignmentParts, 3> without;
  for (std::size_t part = 0; part < kAlignmentParts; ++part) {
    AlignmentSystem rest = all;
    rest.add(parts[part], -1);
    const auto y = step_of(rest.*H, rest.g, yaw, delay);
    if (!y) return Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
    without.row(static_cast<Eigen::Index>(part)) = y->transpose();
  }
  const Eigen::RowVector3d mean = without.colwise().mean();
  return ((kAlignmentParts - 1) * (without.rowwise() - mean).array().square().colwise().mean())
      .sqrt()
      .transpose();
}

/// The least of the cost near a change, by its quadratic, with the jackknife.
Refined refine(const AlignmentCost& cost, double scale, const AlignmentChange& start, bool yaw,
               bool delay) {
  Refined out{start};
  for (int round = 0; round < kRefinements; ++round) {
    const std::array<AlignmentSystem, kAlignmentParts> parts = cost.linearize(out.change, scale);
    AlignmentSystem all;
    for (const AlignmentSystem& part : parts) all.add(part, 1);
    const auto x = step_of(all.H, all.g, yaw, delay);
    out = Refined{out.change};
    if (!x) return out;
    const Eigen::Vector3d spread = jackknife_spread(parts, all, &AlignmentSystem::H, yaw, delay);
    Eigen::Vector3d true_spread =
        jackknife_spread(parts, all, &AlignmentSystem::true_H, yaw, delay);
    if (!true_spread.allFinite()) true_spread = spread;
    out.change.yaw = wrap_angle(out.change.yaw + std::clamp((*x)[0], -kYawStep, kYawStep));
    out.change.delay += std::clamp((*x)[1], -kDelayStep, kDelayStep);
    out.change.drift += (*x)[2];
    if (yaw) {
      out.yaw_sigma = spread[0];
      out.true_yaw_sigma = true_spread[0];
    }
    if (delay) {
      out.delay_sigma = spread[1];
      out.true_delay_sigma = true_spread[1];
    }
    if (std::abs((*x)[0]) < 1e-4 && std::abs((*x)[1]) < 1e-3) break;
  }
  return out;
}

/// By how many standard deviations the first costs less, over stretches of the log. A delay shows
/// in turns alone: ten parts, some with many and some with none, would not tell how sure it is.
double sigmas_better(const AlignmentCost& cost, double scale, const AlignmentChange& better,
                     const AlignmentChange& worse) {
  const std::vector<double> b = cost.costs_by_stretch(better, scale);
  const std::vector<double> w = cost.costs_by_stretch(worse, scale);
  const Eigen::Map<const Eigen::ArrayXd> less(b.data(), static_cast<Eigen::Index>(b.size()));
  const Eigen::Map<const Eigen::ArrayXd> more(w.data(), static_cast<Eigen::Index>(w.size()));
  const auto n = static_cast<double>(b.size());
  if (n < kFewestStretches) return 0;
  const Eigen::ArrayXd d = more - less;
  const double variance = n * (d - d.mean()).square().sum() / (n - 1);
  return variance > 0 ? d.sum() / std::sqrt(variance) : 0;
}

/// The median time between poses [s].
double interval_of(const std::vector<OdometryPose>& odometry) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < odometry.size(); ++i) {
    intervals.push_back(odometry[i].time - odometry[i - 1].time);
  }
  return median(std::move(intervals));
}

/// The delay next to none that falls between poses of the odometry as another does. Motion between
/// poses averages their noise, so that others seem to agree better or worse whatever the clock.
double none_like(double delay, double interval) {
  return interval > 0 ? delay - interval * std::round(delay / interval) : 0;
}

bool beyond(double value, double sigma) {
  return std::abs(value) > kAlignmentSigmas * sigma;
}

/// A change that states yaw and delay, with the drift that goes best with them.
AlignmentChange with_its_drift(const AlignmentCost& cost, double scale,
                               const AlignmentChange& change) {
  return refine(cost, scale, change, false, false).change;
}

/// Yaw and delay for one sign, of which those that are not significant are none.
Refined settle(const AlignmentCost& cost, double scale, const AlignmentChange& start,
               double interval) {
  const Refined both = refine(cost, scale, start, true, true);
  AlignmentChange without_yaw = both.change, without_delay = both.change;
  without_yaw.yaw = 0;
  without_delay.delay = none_like(both.change.delay, interval);
  without_yaw = with_its_drift(cost, scale, without_yaw);
  without_delay = with_its_drift(cost, scale, without_delay);
  const bool yaw = beyond(both.change.yaw, both.yaw_sigma) &&
                   sigmas_better(cost, scale, both.change, without_yaw) > kAlignmentSigmas;
  const bool delay = beyond(both.change.delay, both.delay_sigma) &&
                     std::abs(both.change.delay) < kLongestDelay &&
                     sigmas_better(cost, scale, both.change, without_delay) > kAlignmentSigmas;
  if (yaw && delay) return both;
  const bool mirrored = start.mirrored;
  Refined out = both;
  out.change = {mirrored, 0, 0, both.change.drift};
  if (yaw) {
    out = refine(cost, scale, {mirrored, both.change.yaw, 0, 0}, true, false);
    out.delay_sigma = both.delay_sigma;
    out.true_delay_sigma = both.true_delay_sigma;
    if (!beyond(out.change.yaw, out.yaw_sigma)) out.change.yaw = 0;
  } else if (delay) {
    out = refine(cost, scale, {mirrored, 0, both.change.delay, 0}, false, true);
    out.yaw_sigma = both.yaw_sigma;
    out.true_yaw_sigma = both.true_yaw_sigma;
    if (!beyond(out.change.delay, out.delay_sigma)) out.change.delay = 0;
  }
  return out;
}

/// What ranges are to be multiplied by if they, or the odometry, are in another unit than metres; 1
/// where metres fit as well.
double range_unit(AlignmentCost& cost) {
  std::vector<double> lengths;
  for (const LengthUnit& unit : kLengthUnits) {
    lengths.push_back(unit.metres);
    lengths.push_back(1 / unit.metres);
  }
  double least = least_scale(cost), length = 1;
  for (const double other : lengths) {
    const double scale = least_scale(cost, other);
    if (!(scale < least)) continue;
    least = scale;
    length = other;
  }
  if (length == 1 || !(least > 0)) return 1;
  cost.limit(kFineComparisons);
  const double sigmas = sigmas_better(cost, least, best_of(cost, least, mountings(length)),
                                      best_of(cost, least, mountings(1)));
  cost.limit(kCoarseComparisons);
  return sigmas > kUnitSigmas ? 1 / length : 1;
}

std::string what_is_unknown(double shift, double turn, const SensorAlignment& alignment) {
  if (shift < kLeastShift && turn < kLeastTurn) return "sign, mounting and delay: the robot rests";
  if (turn < kLeastTurn) return "sign and delay: the robot does not turn";
  if (shift < kLeastShift) return "mounting: the robot does not move from its place";
  if (std::isinf(alignment.yaw_sigma) && std::isinf(alignment.delay_sigma)) {
    return "mounting and delay: nothing seen depends on them";
  }
  return "";
}

}  // namespace

SensorAlignment estimate_sensor_alignment(const std::vector<OdometryPose>& odometry,
                                          const std::vector<TimedSightings>& sightings) {
  SensorAlignment out;
  AlignmentCost cost(odometry, sightings, kLongestDelay);
  if (odometry.empty() || cost.pairs() < kFewestFramePairs) {
    out.unknown = "sign, mounting and delay: too few frames with detections";
    return out;
  }
  const auto [shift, turn] = cost.motion();
  cost.limit(kCoarseComparisons);
  if (cost.used() < kFewestUsed) {
    out.unknown = "sign, mounting and delay: too many detections in each frame";
    return out;
  }
  out.length = range_unit(cost);
  if (out.length != 1) {
    out.unknown = "sign, mounting and delay: ranges and odometry seem to have different units";
    return out;
  }
  const double scale = least_scale(cost);
  if (!(scale > 0) || !std::isfinite(scale)) {
    out.unknown = "sign, mounting and delay: detections agree at any";
    return out;
  }
  const AlignmentChange as_it_is = search_yaw(cost, scale, false);
  const AlignmentChange other = search_yaw(cost, scale, true);
  cost.limit(kFineComparisons);
  const double sign = sigmas_better(cost, scale, other, as_it_is);
  out.mirror_sigmas = std::abs(sign);
  out.mirrored = sign > kAlignmentSigmas;
  cost.limit(kCoarseComparisons);
  const AlignmentChange start = search_delay(cost, scale, out.mirrored ? other : as_it_is);
  cost.limit(kFineComparisons);
  const double interval = interval_of(odometry);
  const Refined found = settle(cost, scale, start, interval);
  out.yaw = found.change.yaw;
  out.delay = found.change.delay;
  out.yaw_sigma = found.true_yaw_sigma;
  out.delay_sigma = found.true_delay_sigma;
  out.unknown = what_is_unknown(shift, turn, out);
  const AlignmentChange as_stated = with_its_drift(
      cost, scale, {false, 0, none_like(found.change.delay, interval), found.change.drift});
  const double gain = sigmas_better(cost, scale, found.change, as_stated);
  out.is_significant = (out.mirrored || out.yaw != 0 || out.delay != 0) && gain > kAlignmentSigmas;
  if (!out.is_significant) {
    out.mirrored = false;
    out.yaw = out.delay = 0;
  }
  return out;
}

}  // namespace hybrid
