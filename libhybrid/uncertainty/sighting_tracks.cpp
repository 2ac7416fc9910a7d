// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/detail/sighting_tracks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "libhybrid/core/quantile.h"
#include "libhybrid/geometry/polar.h"

namespace hybrid {
namespace {

constexpr double kMostComparisons = 2e6;  // of detections: a tenth of a second
constexpr double kStretchFrames = 64;     // twice those over which errors that last show
constexpr int kMatchings = 4, kMixtures = 8;
// Between two frames a second apart: a robot that comes no farther is at rest.
constexpr double kRestSeconds = 1, kRestShift = 0.05, kRestTurn = 0.02;  // s, m, rad

/// The frames that saw something, by number; without `at_rest` those that the robot was moving at.
std::vector<std::size_t> frames_to_use(const std::vector<MovedSightings>& frames, bool at_rest) {
  std::vector<std::size_t> out;
  std::size_t before = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].chain != frames[before].chain) before = i;
    while (before + 1 < i &&
           frames[i].sightings.time - frames[before].sightings.time > kRestSeconds) {
      ++before;
    }
    const SE3::Tangent moved =
        frames[before].T_odometry_robot.between(frames[i].T_odometry_robot).log();
    const bool moves = moved.head<3>().norm() > kRestShift || moved.tail<3>().norm() > kRestTurn;
    if ((moves || at_rest) && !frames[i].sightings.seen.empty()) out.push_back(i);
  }
  return out;
}

/// The stretch of the log that each frame is of; -1: it is not used. All of `used` are, as far as
/// the budget of comparisons goes; else successive ones in stretches that are evenly spread.
std::vector<int> stretches_of(const std::vector<MovedSightings>& frames,
                              const std::vector<std::size_t>& used) {
  std::vector<int> out(frames.size(), -1);
  std::vector<double> cost(used.size());
  double all = 0, before = 0;
  for (std::size_t k = 0; k < used.size(); ++k) {
    const auto n = static_cast<double>(frames[used[k]].sightings.seen.size());
    all += cost[k] = n * (n + before);
    before = n;
  }
  const double share = std::min(1.0, kMostComparisons / std::max(1.0, all));
  const auto frames_to_have = share * static_cast<double>(used.size());
  const auto count = static_cast<std::size_t>(
      share < 1 ? std::clamp(frames_to_have / kStretchFrames, 1.0, static_cast<double>(kLogParts))
                : 1);
  std::vector<double> spent(count);
  for (std::size_t k = 0; k < used.size(); ++k) {
    const std::size_t stretch = k * count / used.size();
    spent[stretch] += cost[k];
    if (share == 1 || spent[stretch] <= kMostComparisons / static_cast<double>(count)) {
      out[used[k]] = static_cast<int>(stretch);
    }
  }
  return out;
}

void add_motion(const MovedSightings& moved, PolarFrame& frame) {
  const SE3::Jacobian& Q = moved.motion_covariance;
  const bool in_space = Q(2, 2) > 0 || Q(3, 3) > 0;
  const double rotation = in_space ? Q.diagonal().tail<3>().mean() : Q(5, 5);
  frame.translation += in_space ? Q.diagonal().head<3>().mean() : 0.5 * (Q(0, 0) + Q(1, 1));
  frame.rotation += rotation;
  const Eigen::Vector3d at = moved.T_odometry_robot.translation();
  frame.moment += rotation * at;
  frame.second_moment += rotation * at * at.transpose();
}

PolarSighting polar_sighting(const MeasuredPoint& measured, const SE3& T_odometry_sensor) {
  PolarSighting out;
  const Eigen::Index dim = measured.z.size();
  out.z.head(dim) = measured.z;
  out.stated.head(dim) = measured.covariance.diagonal();
  out.point = T_odometry_sensor * from_polar(out.z);
  return out;
}

}  // namespace

PolarLog polar_log(const std::vector<MovedSightings>& frames, bool at_rest) {
  PolarLog log;
  log.axes = 3;
  PolarFrame sums;
  const std::vector<int> stretches = stretches_of(frames, frames_to_use(frames, at_rest));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const TimedSightings& seen = frames[i].sightings;
    PolarFrame frame = sums;
    frame.time = seen.time;
    // Stretches do not follow each other.
    frame.chain = frames[i].chain * kLogParts + std::max(0, stretches[i]);
    add_motion(frames[i], frame);
    sums = frame;
    if (stretches[i] < 0) continue;
    frame.T_odometry_sensor = frames[i].T_odometry_robot * seen.T_robot_sensor;
    for (std::size_t k = 0; k < seen.seen.size(); ++k) {
      if (seen.seen[k].z.size() < 3) log.axes = 2;
      frame.seen.push_back(polar_sighting(seen.seen[k], frame.T_odometry_sensor));
      if (!frames[i].ids.empty()) frame.seen.back().id = frames[i].ids[k];
    }
    log.frames.push_back(std::move(frame));
  }
  for (std::size_t i = 0; i < log.frames.size(); ++i) {
    log.frames[i].part = static_cast<int>(i * kLogParts / log.frames.size());
  }
  return log;
}

void add_rows(const PolarLog& log, const SightingPair& pair, bool by_stated,
              std::vector<VarianceRow>& out) {
  const PolarFrame &from = log.frames[pair.first_frame], &to = log.frames[pair.second_frame];
  const ExpectedSighting expected =
      expected_sighting(from, from.seen[static_cast<std::size_t>(pair.first)], to, by_stated);
  const PolarSighting& seen = to.seen[static_cast<std::size_t>(pair.second)];
  const Eigen::Vector3d e = innovation_of(expected, seen.z);
  for (int k = 0; k < log.axes; ++k) {
    out.push_back(
        {expected.shares[static_cast<std::size_t>(k)], 0, e[k] * e[k], pair.probability, to.part});
  }
}

std::vector<VarianceRow> rows_of(const PolarLog& log, const std::vector<SightingPair>& pairs,
                                 bool by_stated) {
  std::vector<VarianceRow> rows;
  for (const SightingPair& pair : pairs) add_rows(log, pair, by_stated, rows);
  return rows;
}

namespace {

/// Variances that make the nearer half of the pairs fit.
Components spread_of(const PolarLog& log, const std::vector<SightingPair>& pairs,
                     const Components& metric) {
  const std::vector<VarianceRow> rows = rows_of(log, pairs, false);
  const auto axes = static_cast<std::size_t>(log.axes);
  std::vector<double> distances;
  for (std::size_t i = 0; i + axes <= rows.size(); i += axes) {
    double sum = 0;
    for (std::size_t k = 0; k < axes; ++k)
      sum += rows[i + k].square / rows[i + k].shares.dot(metric);
    distances.push_back(sum);
  }
  return std::max(1e-12, median(distances) / log.axes) * metric;
}

/// Sets the probabilities of pairs, and returns the share that is of one thing.
double judge(const std::vector<VarianceRow>& rows, const Components& variances, int axes,
             double share, std::vector<SightingPair>& pairs) {
  double sum = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    double log_density = 0;
    for (int k = 0; k < axes; ++k) {
      const VarianceRow& row =
          rows[i * static_cast<std::size_t>(axes) + static_cast<std::size_t>(k)];
      const double v = std::max(1e-18, row.shares.dot(variances));
      log_density -= 0.5 * (std::log(2 * M_PI * v) + row.square / v);
    }
    const double right = share * std::exp(log_density), wrong = (1 - share) * pairs[i].clutter;
    pairs[i].probability = right + wrong > 0 ? right / (right + wrong) : 0;
    sum += pairs[i].probability;
  }
  return pairs.empty() ? 0 : sum / static_cast<double>(pairs.size());
}

}  // namespace

PairMixture fit_mixture(const PolarLog& log) {
  PairMixture mixture;
  // To begin with distances count as they are in space, and odometry as it is stated.
  Components metric = Components::Zero();
  metric[kRange] = metric[kAcross] = 1;
  mixture.variances = spread_of(log, nearest_pairs(log, metric), metric);
  for (int matching = 0; matching < kMatchings; ++matching) {
    mixture.pairs = nearest_pairs(log, mixture.variances);
    std::vector<VarianceRow> rows = rows_of(log, mixture.pairs, false);
    for (int round = 0; round < kMixtures; ++round) {
      mixture.share = std::clamp(
          judge(rows, mixture.variances, log.axes, mixture.share, mixture.pairs), 0.01, 0.999);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        rows[i].weight = mixture.pairs[i / static_cast<std::size_t>(log.axes)].probability;
      }
      mixture.variances = fit_variances(rows, mixture.variances);
    }
  }
  return mixture;
}

void follow(const std::vector<SightingPair>& pairs, PolarLog& log) {
  int tracks = 0;
  for (const SightingPair& pair : pairs) {
    if (pair.probability < 0.5) continue;
    PolarSighting& a = log.frames[pair.first_frame].seen[static_cast<std::size_t>(pair.first)];
    PolarSighting& b = log.frames[pair.second_frame].seen[static_cast<std::size_t>(pair.second)];
    if (a.track < 0) a.track = tracks++;
    b.track = a.track;
  }
}

std::vector<SightingPair> pairs_at(const PolarLog& log, std::size_t lag) {
  std::vector<SightingPair> out;
  for (std::size_t j = lag; j < log.frames.size(); ++j) {
    const PolarFrame &from = log.frames[j - lag], &to = log.frames[j];
    if (from.chain != to.chain) continue;
    std::map<int, int> first;
    for (std::size_t i = 0; i < from.seen.size(); ++i) {
      if (from.seen[i].track >= 0) first[from.seen[i].track] = static_cast<int>(i);
    }
    for (std::size_t i = 0; i < to.seen.size(); ++i) {
      const auto it = first.find(to.seen[i].track);
      if (it != first.end()) out.push_back({j - lag, j, it->second, static_cast<int>(i), 0, 0, 1});
    }
  }
  return out;
}

}  // namespace hybrid
