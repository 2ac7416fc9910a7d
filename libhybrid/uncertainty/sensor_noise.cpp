// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/sensor_noise.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>

#include "libhybrid/core/quantile.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/uncertainty/detail/sighting_tracks.h"

namespace hybrid {
namespace {

constexpr double kSure = 0.15;
const double kFar = std::log(1.5);
constexpr double kFarSigmas = 3;
constexpr double kLasting = 2;                 // s, over which errors that last show
constexpr std::size_t kFewestPairs = 50;       // five a part
constexpr double kMostChance = 0.5;            // other things within the noise
constexpr int kLags[] = {1, 2, 4, 8, 16, 32};  // frames
constexpr double kLeastShare = 0.2;            // of pairs that are of one thing
constexpr int kGrowthRounds = 5;

/// What the residuals of the pairs of two frames disagree by, beside a motion common to all: sums
/// of squares over what the variances explain, and those expected, for ranges and angles.
struct Disagreement {
  Eigen::Vector2d square = Eigen::Vector2d::Zero(), expected = Eigen::Vector2d::Zero();
};

Disagreement disagreement(const PolarLog& log, const std::vector<SightingPair>& pairs,
                          std::size_t begin, std::size_t end, bool by_stated,
                          const Components& variances) {
  const int n = static_cast<int>(end - begin), axes = log.axes, motion = axes == 2 ? 3 : 6;
  Disagreement out;
  if (n * axes <= motion) return out;
  Eigen::MatrixXd H(n * axes, motion);
  Eigen::VectorXd e(n * axes);
  for (int i = 0; i < n; ++i) {
    const SightingPair& pair = pairs[begin + static_cast<std::size_t>(i)];
    const PolarFrame &from = log.frames[pair.first_frame], &to = log.frames[pair.second_frame];
    const PolarSighting& a = from.seen[static_cast<std::size_t>(pair.first)];
    const ExpectedSighting expected = expected_sighting(from, a, to, by_stated);
    const Eigen::Vector3d innovation =
        innovation_of(expected, to.seen[static_cast<std::size_t>(pair.second)].z);
    const Eigen::Vector3d p = to.T_odometry_sensor.inverse() * a.point;
    Eigen::Matrix3d J;
    to_polar(p, &J);
    J.row(1) *= std::cos(expected.z[2]);
    Eigen::Matrix<double, 3, 6> move;
    move.leftCols<3>() = J;
    for (int k = 0; k < 3; ++k) move.col(3 + k) = J * Eigen::Vector3d::Unit(k).cross(p);
    for (int k = 0; k < axes; ++k) {
      Components sensor = expected.shares[static_cast<std::size_t>(k)];
      sensor[kTranslation] = sensor[kRotation] = 0;
      const double whiten = 1 / std::sqrt(std::max(1e-18, sensor.dot(variances)));
      const int row = i * axes + k;
      e[row] = whiten * innovation[k];
      if (axes == 3) {
        H.row(row) = whiten * move.row(k);
      } else {
        H.row(row) << whiten * move(k, 0), whiten * move(k, 1), whiten * move(k, 5);
      }
    }
  }
  const Eigen::MatrixXd N = H.transpose() * H + 1e-9 * Eigen::MatrixXd::Identity(motion, motion);
  const Eigen::MatrixXd G = N.ldlt().solve(H.transpose());
  const Eigen::VectorXd rest = e - H * (G * e);
  for (int row = 0; row < n * axes; ++row) {
    const int kind = row % axes == 0 ? 0 : 1;
    const double free = std::max(0.0, 1 - H.row(row).dot(G.col(row)));
    out.square[kind] += std::min(rest[row] * rest[row], 25 * free);
    out.expected[kind] += free;
  }
  return out;
}

/// How far residuals of pairs a time apart exceed the variances.
SensorNoise::Lag measure_lag(const PolarLog& log, std::size_t lag, bool by_stated,
                             const Components& variances) {
  const std::vector<SightingPair> pairs = pairs_at(log, lag);
  SensorNoise::Lag out;
  std::vector<double> seconds;
  Disagreement sum;
  for (std::size_t begin = 0, end = 0; begin < pairs.size(); begin = end) {
    while (end < pairs.size() && pairs[end].second_frame == pairs[begin].second_frame) ++end;
    const Disagreement d = disagreement(log, pairs, begin, end, by_stated, variances);
    if (d.expected.sum() < 0.5) continue;
    sum.square += d.square;
    sum.expected += d.expected;
    seconds.push_back(log.frames[pairs[begin].second_frame].time -
                      log.frames[pairs[begin].first_frame].time);
  }
  out.pairs = seconds.size();
  out.seconds = median(seconds);
  if (sum.expected[0] > 5) out.range = std::sqrt(sum.square[0] / sum.expected[0]);
  if (sum.expected[1] > 5) out.angle = std::sqrt(sum.square[1] / sum.expected[1]);
  return out;
}

/// Variances of sensor noise that is so many times as large, in ranges and angles.
Components grown(Components variances, const Eigen::Vector2d& growth) {
  for (const NoisePart part : {kRange, kRangeShare}) variances[part] *= growth[0] * growth[0];
  for (const NoisePart part : {kAngle, kAcross}) variances[part] *= growth[1] * growth[1];
  return variances;
}

/// What errors over the longest time are to those of the fit, for ranges and angles; 1 where they
/// have grown by no more than noise is known to. The noise of the one shows in the other where the
/// robot goes around things: both are asked again with what the other has come to.
Eigen::Vector2d growth_over(const PolarLog& log, bool by_stated, const Components& variances,
                            const std::vector<SensorNoise::Lag>& lags, std::size_t longest) {
  Eigen::Vector2d growth = Eigen::Vector2d::Ones();
  if (lags.empty()) return growth;
  const SensorNoise::Lag &first = lags.front(), &last = lags.back();
  const bool range = last.range > (1 + kSure) * first.range;
  const bool angle = last.angle > (1 + kSure) * first.angle;
  if (!range && !angle) return growth;
  for (int round = 0; round < kGrowthRounds; ++round) {
    const SensorNoise::Lag more = measure_lag(log, longest, by_stated, grown(variances, growth));
    if (range) growth[0] *= more.range;
    if (angle) growth[1] *= more.angle;
  }
  return growth.cwiseMax(1);
}

/// Relates how errors grow to successive sightings.
void relate_to_first(std::vector<SensorNoise::Lag>& lags) {
  if (lags.empty()) return;
  const SensorNoise::Lag first = lags.front();
  for (SensorNoise::Lag& lag : lags) {
    lag.range /= std::max(1e-9, first.range);
    lag.angle /= std::max(1e-9, first.angle);
  }
}

/// The value of `of` for the fit to all rows, and its standard deviation.
Measured jackknife(const std::vector<Components>& without, const Components& all,
                   const std::function<double(const Components&)>& of) {
  Eigen::ArrayXd values(static_cast<Eigen::Index>(without.size()));
  for (std::size_t i = 0; i < without.size(); ++i) {
    values[static_cast<Eigen::Index>(i)] = of(without[i]);
  }
  const double spread = (values - values.mean()).square().mean();
  return {of(all), std::sqrt(static_cast<double>(without.size() - 1) * spread)};
}

std::vector<Components> leave_each_out(const std::vector<VarianceRow>& rows,
                                       const Components& all) {
  std::vector<Components> out;
  for (int part = 0; part < kLogParts; ++part) out.push_back(fit_variances(rows, all, part));
  return out;
}

/// Ranges and stated variances of what was paired.
void describe(const PolarLog& log, const std::vector<SightingPair>& pairs, SensorNoise& noise) {
  std::vector<double> ranges;
  double range = 0, angle = 0, weight = 0;
  for (const SightingPair& pair : pairs) {
    if (pair.probability < 0.5) continue;
    const PolarSighting& seen =
        log.frames[pair.second_frame].seen[static_cast<std::size_t>(pair.second)];
    ranges.push_back(seen.z[0]);
    range += seen.stated[0];
    angle += seen.stated[1];
    weight += 1;
  }
  noise.pairs = ranges.size();
  noise.at_range = median(ranges);
  if (weight > 0) noise.stated_range = std::sqrt(range / weight);
  if (weight > 0) noise.stated_angle = std::sqrt(angle / weight);
}

/// The expected number of things that are as near to a sighting by chance as the noise leads.
double chance_of(const PolarLog& log, const PairMixture& mixture) {
  const std::vector<VarianceRow> rows = rows_of(log, mixture.pairs, false);
  double sum = 0;
  const auto axes = static_cast<std::size_t>(log.axes);
  for (std::size_t i = 0; i < mixture.pairs.size(); ++i) {
    double determinant = 1;
    for (std::size_t k = 0; k < axes; ++k) {
      determinant *= rows[i * axes + k].shares.dot(mixture.variances);
    }
    sum += mixture.pairs[i].density * M_PI * std::sqrt(determinant);
  }
  return mixture.pairs.empty() ? 0 : sum / static_cast<double>(mixture.pairs.size());
}

bool states_all(const PolarLog& log) {
  for (const PolarFrame& frame : log.frames) {
    for (const PolarSighting& seen : frame.seen) {
      if (!(seen.stated.head(log.axes).minCoeff() > 0)) return false;
    }
  }
  return true;
}

/// The components of the noise that rows of pairs of sightings tell, and what they are without each
/// part of the log.
struct NoiseFit {
  Components variances;
  std::vector<Components> without;
};

/// \param is_scaled set where factors of the stated noise explain the rows better than noise of one
/// size
NoiseFit fit_rows(const PolarLog& log, const PairMixture& mixture, bool& is_scaled) {
  // Successive sightings, and those farther apart, which tell noise of the sensor from that of the
  // odometry.
  std::vector<VarianceRow> rows = rows_of(log, mixture.pairs, false);
  std::vector<VarianceRow> stated_rows = rows_of(log, mixture.pairs, true);
  for (const int lag : kLags) {
    for (const SightingPair& pair : pairs_at(log, static_cast<std::size_t>(lag))) {
      if (lag == 1) continue;
      add_rows(log, pair, false, rows);
      add_rows(log, pair, true, stated_rows);
    }
  }
  Components variances = fit_variances(rows, mixture.variances);
  if (states_all(log)) {
    Components start = Components::Ones();
    start[kRangeShare] = start[kAcross] = 0;
    const Components factors = fit_variances(stated_rows, start);
    // Two numbers more must be worth their price (BIC).
    const double price = std::log(static_cast<double>(rows.size()));
    if (log_likelihood(stated_rows, factors) > log_likelihood(rows, variances) - price) {
      is_scaled = true;
      variances = factors;
      rows = std::move(stated_rows);
    }
  }
  return {variances, leave_each_out(rows, variances)};
}

/// Notes what was found, of the size that errors have grown to over the lags.
void note_components(const NoiseFit& fit, const Eigen::Vector2d& growth, SensorNoise& noise) {
  const Components& variances = fit.variances;
  const double r = noise.at_range, stated_range = noise.stated_range;
  const double stated_angle = noise.stated_angle;
  const bool scaled = noise.is_scaled;
  noise.range = jackknife(fit.without, variances, [&](const Components& v) {
    return growth[0] * (scaled ? stated_range * std::sqrt(v[kRange])
                               : std::sqrt(v[kRange] + v[kRangeShare] * r * r));
  });
  noise.angle = jackknife(fit.without, variances, [&](const Components& v) {
    return growth[1] * (scaled ? stated_angle * std::sqrt(v[kAngle])
                               : std::sqrt(v[kAngle] + v[kAcross] / (r * r)));
  });
  noise.translation = jackknife(fit.without, variances,
                                [](const Components& v) { return std::sqrt(v[kTranslation]); });
  noise.rotation = jackknife(fit.without, variances,
                             [](const Components& v) { return std::sqrt(v[kRotation]); });
  if (scaled) {
    noise.range_factor = growth[0] * std::sqrt(variances[kRange]);
    noise.angle_factor = growth[1] * std::sqrt(variances[kAngle]);
  } else {
    noise.range_m = growth[0] * std::sqrt(variances[kRange]);
    noise.range_share = growth[0] * std::sqrt(variances[kRangeShare]);
    noise.angle_rad = growth[1] * std::sqrt(variances[kAngle]);
    noise.across_m = growth[1] * std::sqrt(variances[kAcross]);
  }
}

}  // namespace

bool Measured::is_sure() const {
  return value > 0 && sigma <= kSure * value;
}

bool Measured::replaces(double stated) const {
  if (!(value > 0) || !std::isfinite(sigma)) return false;
  if (is_sure() || !(stated > 0)) return true;
  const double away = std::abs(std::log(value / stated));
  return away > kFar && away > kFarSigmas * sigma / value;
}

bool SensorNoise::is_white() const {
  if (!unknown.empty() || lags.empty() || lags.back().seconds < kLasting) return false;
  return std::none_of(lags.begin(), lags.end(), [](const Lag& lag) {
    // The sigma of a standard deviation from so many pairs of frames, with a residual each.
    const double sigma = 1 / std::sqrt(2 * static_cast<double>(lag.pairs));
    return std::max(lag.range, lag.angle) > 1 + std::max(kSure, kFarSigmas * sigma);
  });
}

namespace {

SensorNoise measure(PolarLog log) {
  SensorNoise noise;
  if (log.frames.size() < kLogParts) {
    noise.unknown = "too few frames with detections";
    return noise;
  }
  const PairMixture mixture = fit_mixture(log);
  describe(log, mixture.pairs, noise);
  noise.chance = chance_of(log, mixture);
  if (noise.pairs < kFewestPairs) {
    noise.unknown = "too few things are seen in two frames";
    return noise;
  }
  if (noise.chance > kMostChance || mixture.share < kLeastShare) {
    noise.unknown = "things are too close together to be told apart from frame to frame";
    return noise;
  }
  follow(mixture.pairs, log);

  const NoiseFit fit = fit_rows(log, mixture, noise.is_scaled);
  std::size_t longest = 0;
  for (const int lag : kLags) {
    const SensorNoise::Lag measured =
        measure_lag(log, static_cast<std::size_t>(lag), noise.is_scaled, fit.variances);
    if (measured.pairs < kFewestPairs) continue;
    noise.lags.push_back(measured);
    longest = static_cast<std::size_t>(lag);
  }
  const Eigen::Vector2d growth =
      growth_over(log, noise.is_scaled, fit.variances, noise.lags, longest);
  relate_to_first(noise.lags);
  note_components(fit, growth, noise);
  return noise;
}

}  // namespace

SensorNoise measure_sensor_noise(const std::vector<MovedSightings>& frames) {
  SensorNoise noise = measure(polar_log(frames, false));
  return noise.unknown.empty() ? noise : measure(polar_log(frames, true));
}

}  // namespace hybrid
