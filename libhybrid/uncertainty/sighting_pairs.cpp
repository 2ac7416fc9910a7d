// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/detail/sighting_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libhybrid/geometry/polar.h"
#include "libhybrid/geometry/so2.h"

namespace hybrid {
namespace {

constexpr std::size_t kFramesBack = 5;  // over which a thing may be missed
constexpr double kLeastRange = 1e-3;    // m

/// The noise of the motion between two frames, as it moves a point seen along `u` at a range.
struct MotionShares {
  double translation = 0, range = 0, angle = 0;
};

MotionShares motion_shares(const PolarFrame& from, const PolarFrame& to, const Eigen::Vector3d& u,
                           double range) {
  const Eigen::Vector3d s = to.T_odometry_sensor.translation();
  const double all = to.rotation - from.rotation;
  const Eigen::Vector3d first = to.moment - from.moment;
  const Eigen::Matrix3d second = to.second_moment - from.second_moment;
  // Sums over the motions, weighted by the variances of their rotations, of d = c - s.
  const double squares = std::max(0.0, second.trace() - 2 * s.dot(first) + all * s.squaredNorm());
  const double along = u.dot(first) - all * u.dot(s);
  const double along2 =
      std::max(0.0, u.dot(second * u) - 2 * u.dot(s) * u.dot(first) + all * std::pow(u.dot(s), 2));
  MotionShares out;
  out.translation = std::max(0.0, to.translation - from.translation);
  out.range = std::max(0.0, squares - along2);
  out.angle = std::max(0.0, range * range * all - 2 * range * along + along2) / (range * range);
  return out;
}

/// How far the detections of a log reach in one coordinate, without the outermost tenth.
double extent_of(const PolarLog& log, int axis) {
  std::vector<double> all;
  for (const PolarFrame& frame : log.frames) {
    for (const PolarSighting& seen : frame.seen) all.push_back(seen.z[axis]);
  }
  if (all.empty()) return 1;
  std::sort(all.begin(), all.end());
  const std::size_t cut = all.size() / 20;
  return std::max(1e-3, (all[all.size() - 1 - cut] - all[cut]) / 0.9);
}

struct ActiveSighting {
  std::size_t frame = 0;
  int index = 0;
};

double ellipsoid_volume(double distance2, double determinant, int axes) {
  const double d = std::sqrt(distance2), unit = axes == 2 ? M_PI * d * d : 4 * M_PI / 3 * d * d * d;
  return unit * std::sqrt(determinant);
}

struct NearestSighting {
  int index = -1;
  double distance2 = std::numeric_limits<double>::infinity();
  double volume = 0;  // in which there is nothing nearer
};

bool may_be_one(const PolarSighting& a, const PolarSighting& b) {
  return !a.id || !b.id || *a.id == *b.id;
}

/// The pairs of one frame with what is still looked for.
void match_frame(const PolarLog& log, const Components& variances,
                 const std::vector<ActiveSighting>& active, std::size_t second, double extents,
                 std::vector<SightingPair>& out) {
  const PolarFrame& frame = log.frames[second];
  std::vector<NearestSighting> of_active(active.size()), of_seen(frame.seen.size());
  for (std::size_t i = 0; i < active.size(); ++i) {
    const PolarFrame& from = log.frames[active[i].frame];
    const PolarSighting& a = from.seen[static_cast<std::size_t>(active[i].index)];
    const ExpectedSighting expected = expected_sighting(from, a, frame, false);
    Eigen::Vector3d v = Eigen::Vector3d::Ones();
    double determinant = 1;
    for (int k = 0; k < log.axes; ++k) {
      v[k] = std::max(1e-18, expected.shares[static_cast<std::size_t>(k)].dot(variances));
      determinant *= v[k];
    }
    for (std::size_t j = 0; j < frame.seen.size(); ++j) {
      if (!may_be_one(a, frame.seen[j])) continue;
      const Eigen::Vector3d e = innovation_of(expected, frame.seen[j].z);
      double distance2 = 0;
      for (int k = 0; k < log.axes; ++k) distance2 += e[k] * e[k] / v[k];
      const double empty = ellipsoid_volume(distance2, determinant, log.axes);
      if (distance2 < of_active[i].distance2)
        of_active[i] = {static_cast<int>(j), distance2, empty};
      if (distance2 < of_seen[j].distance2) of_seen[j] = {static_cast<int>(i), distance2, empty};
    }
  }
  const double density = static_cast<double>(std::max(active.size(), frame.seen.size())) / extents;
  for (std::size_t j = 0; j < of_seen.size(); ++j) {
    const int i = of_seen[j].index;
    if (i < 0 || of_active[static_cast<std::size_t>(i)].index != static_cast<int>(j)) continue;
    const ActiveSighting& a = active[static_cast<std::size_t>(i)];
    out.push_back({a.frame, second, a.index, static_cast<int>(j), density,
                   density * std::exp(-density * of_seen[j].volume), 1});
  }
}

}  // namespace

ExpectedSighting expected_sighting(const PolarFrame& from, const PolarSighting& seen,
                                   const PolarFrame& to, bool by_stated) {
  ExpectedSighting out;
  const Eigen::Vector3d p = to.T_odometry_sensor.inverse() * seen.point;
  out.z = to_polar(p);
  const double r1 = std::max(kLeastRange, seen.z[0]), r2 = std::max(kLeastRange, out.z[0]);
  const Eigen::Vector3d s2 = to.T_odometry_sensor.translation();
  const Eigen::Vector3d u1 = (seen.point - from.T_odometry_sensor.translation()) / r1;
  const Eigen::Vector3d u2 = (seen.point - s2) / r2;
  const double c2 = std::min(1.0, std::pow(u1.dot(u2), 2)), n2 = 1 - c2;
  const MotionShares motion = motion_shares(from, to, u2, r2);
  for (std::size_t k = 0; k < 3; ++k) out.shares[k].setZero();
  Components& range = out.shares[0];
  range[kRange] = by_stated ? (1 + c2) * seen.stated[0] : 1 + c2;
  range[kRangeShare] = by_stated ? 0 : r2 * r2 + c2 * r1 * r1;
  range[kAngle] = by_stated ? n2 * r1 * r1 * seen.stated[1] : n2 * r1 * r1;
  range[kAcross] = by_stated ? 0 : n2;
  range[kTranslation] = motion.translation;
  range[kRotation] = motion.range;
  for (std::size_t k = 1; k < 3; ++k) {
    const double stated = seen.stated[static_cast<Eigen::Index>(k)];
    const double turned = r1 * r1 / (r2 * r2);
    Components& angle = out.shares[k];
    angle[kRange] = (by_stated ? n2 * seen.stated[0] : n2) / (r2 * r2);
    angle[kRangeShare] = by_stated ? 0 : n2 * turned;
    angle[kAngle] = by_stated ? (1 + c2 * turned) * stated : 1 + c2 * turned;
    angle[kAcross] = by_stated ? 0 : (1 + c2) / (r2 * r2);
    angle[kTranslation] = motion.translation / (r2 * r2);
    angle[kRotation] = motion.angle;
  }
  return out;
}

Eigen::Vector3d innovation_of(const ExpectedSighting& expected, const Eigen::Vector3d& z) {
  Eigen::Vector3d e = z - expected.z;
  e[1] = wrap_angle(e[1]) * std::cos(expected.z[2]);
  return e;
}

std::vector<SightingPair> nearest_pairs(const PolarLog& log, const Components& variances) {
  double extents = 1;
  for (int k = 0; k < log.axes; ++k) extents *= extent_of(log, k);
  std::vector<SightingPair> out;
  std::vector<ActiveSighting> active;
  for (std::size_t j = 0; j < log.frames.size(); ++j) {
    const PolarFrame& frame = log.frames[j];
    active.erase(std::remove_if(active.begin(), active.end(),
                                [&](const ActiveSighting& a) {
                                  return a.frame + kFramesBack < j ||
                                         log.frames[a.frame].chain != frame.chain;
                                }),
                 active.end());
    const std::size_t before = out.size();
    match_frame(log, variances, active, j, extents, out);
    for (std::size_t k = before; k < out.size(); ++k) {
      active.erase(std::find_if(active.begin(), active.end(), [&](const ActiveSighting& a) {
        return a.frame == out[k].first_frame && a.index == out[k].first;
      }));
    }
    for (std::size_t i = 0; i < frame.seen.size(); ++i) active.push_back({j, static_cast<int>(i)});
  }
  return out;
}

}  // namespace hybrid
