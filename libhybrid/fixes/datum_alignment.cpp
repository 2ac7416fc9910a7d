// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/fixes/datum_alignment.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "libhybrid/core/quantile.h"

namespace hybrid {
namespace {

constexpr std::size_t kTried = 24;  // pairs, any two of which give a hypothesis
constexpr double kDrift = 0.03;     // of odometry, as a share of the way between two pairs
constexpr double kAgree = 3;        // sigmas
constexpr int kRounds = 10;         // of least squares
constexpr double kStated = 1;       // pairs, as which the sigmas that are stated count

/// A turn about the vertical and a shift in the plane.
struct Planar {
  double turn = 0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const {
    return Eigen::Rotation2Dd(turn) * p + shift;
  }
};

/// The motion that fits some pairs best, and their spread about their middle, sum of squares over
/// sigmas.
Planar fit(const std::vector<DatumPair>& pairs, const std::vector<bool>& used, double& spread) {
  Eigen::Vector2d a = Eigen::Vector2d::Zero(), b = a;
  double weight = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!used[i]) continue;
    const double w = 1 / (pairs[i].sigma * pairs[i].sigma);
    a += w * pairs[i].in_map.head<2>();
    b += w * pairs[i].in_datum.head<2>();
    weight += w;
  }
  a /= weight;
  b /= weight;
  double along = 0, across = 0;
  spread = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!used[i]) continue;
    const double w = 1 / (pairs[i].sigma * pairs[i].sigma);
    const Eigen::Vector2d p = pairs[i].in_map.head<2>() - a, q = pairs[i].in_datum.head<2>() - b;
    along += w * p.dot(q);
    across += w * (p.x() * q.y() - p.y() * q.x());
    spread += w * p.squaredNorm();
  }
  Planar out;
  out.turn = std::atan2(across, along);
  out.shift = b - Eigen::Rotation2Dd(out.turn) * a;
  return out;
}

std::vector<bool> agreeing(const std::vector<DatumPair>& pairs, const Planar& T, double reach) {
  std::vector<bool> out;
  for (const DatumPair& pair : pairs) {
    const double off = (T * pair.in_map.head<2>() - pair.in_datum.head<2>()).norm();
    out.push_back(off <= kAgree * pair.sigma + reach);
  }
  return out;
}

/// Of the errors of some pairs, relative to their sigmas, which may be stated too large.
double variance(const std::vector<DatumPair>& pairs, const std::vector<bool>& used,
                const Planar& T) {
  double squares = 2 * kStated, numbers = 2 * kStated - 3;  // three are fitted
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!used[i]) continue;
    const double sigma = pairs[i].sigma;
    squares += (T * pairs[i].in_map.head<2>() - pairs[i].in_datum.head<2>()).squaredNorm() /
               (sigma * sigma);
    numbers += 2;
  }
  return std::min(1.0, squares / numbers);
}

/// Numbers below n without an order in which every third, say, is false; the same for the same n.
std::vector<std::size_t> some_of(std::size_t n) {
  std::minstd_rand random;
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < n && n <= kTried; ++i) out.push_back(i);
  while (out.size() < std::min(n, kTried)) out.push_back(random() % n);
  return out;
}

std::size_t count(const std::vector<bool>& which) {
  return static_cast<std::size_t>(std::count(which.begin(), which.end(), true));
}

}  // namespace

std::optional<Eigen::Isometry3d> align_to_datum(const std::vector<DatumPair>& pairs,
                                                double most_sigma_turn) {
  if (pairs.size() < 3) return std::nullopt;
  double way = 0;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    way += (pairs[i].in_map - pairs[i - 1].in_map).norm();
  }
  const double reach = kDrift * way;
  const std::vector<std::size_t> tried = some_of(pairs.size());
  std::vector<bool> best;
  for (const std::size_t i : tried) {
    for (const std::size_t j : tried) {
      if (j <= i) continue;
      const Eigen::Vector2d p = (pairs[j].in_map - pairs[i].in_map).head<2>();
      const Eigen::Vector2d q = (pairs[j].in_datum - pairs[i].in_datum).head<2>();
      if (std::abs(p.norm() - q.norm()) > kAgree * (pairs[i].sigma + pairs[j].sigma) + reach) {
        continue;
      }
      Planar T;
      T.turn = std::atan2(p.x() * q.y() - p.y() * q.x(), p.dot(q));
      T.shift = (pairs[i].in_datum + pairs[j].in_datum).head<2>() / 2 -
                Eigen::Rotation2Dd(T.turn) * (pairs[i].in_map + pairs[j].in_map).head<2>() / 2;
      std::vector<bool> agrees = agreeing(pairs, T, reach);
      if (best.empty() || count(agrees) > count(best)) best = std::move(agrees);
    }
  }
  if (2 * count(best) <= pairs.size()) return std::nullopt;
  double spread = 0;
  Planar T = fit(pairs, best, spread);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<bool> agrees = agreeing(pairs, T, reach);
    if (agrees == best || 2 * count(agrees) <= pairs.size()) break;
    best = std::move(agrees);
    T = fit(pairs, best, spread);
  }
  // Errors that last do not average out: each sighting of the direction is worth one fix.
  const double mean_spread = spread / static_cast<double>(count(best));
  if (mean_spread * most_sigma_turn * most_sigma_turn < variance(pairs, best, T)) {
    return std::nullopt;
  }
  std::vector<double> heights;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (best[i]) heights.push_back(pairs[i].in_datum.z() - pairs[i].in_map.z());
  }
  Eigen::Isometry3d out(Eigen::AngleAxisd(T.turn, Eigen::Vector3d::UnitZ()));
  out.translation() << T.shift, median(std::move(heights));
  return out;
}

}  // namespace hybrid
