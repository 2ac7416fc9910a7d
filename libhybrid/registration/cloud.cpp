// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/registration/detail/cloud.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <unordered_map>

#include "libhybrid/core/error.h"
#include "libhybrid/registration/target_cloud.h"

namespace hybrid {
namespace {

constexpr int kSample = 500;              // points in a sample of a cloud
constexpr double kSpacingQuantile = 0.8;  // scans are dense near the sensor and thin far away
constexpr double kNone = 1e-6;   // a spread below this share of the radius is rounding error
constexpr double kSame = 1e-15;  // an extent below this share of the distance is rounding alone
constexpr double kMost = 0.9;    // share of the points that defines the size of a cloud
constexpr double kInLine = 0.3;  // largest ratio of second to first spread of points in line

/// The cell of a point, packed: 21 bits for each axis, enough for grids of two million cells
/// across.
std::uint64_t cell_of(const Eigen::Vector3d& p, const Eigen::Vector3d& low, double cell) {
  std::uint64_t packed = 0;
  for (int axis = 0; axis < 3; ++axis) {
    packed = (packed << 21) | std::uint64_t(std::floor((p[axis] - low[axis]) / cell));
  }
  return packed;
}

/// The middle value of each axis, which a few far points do not move.
Eigen::Vector3d median_of(const Points& points) {
  Eigen::Vector3d median;
  std::vector<double> values(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = points[i][axis];
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    median[axis] = *middle;
  }
  return median;
}

/// Throws Error if all points coincide, or are so far from the origin that rounding there is no
/// longer small beside their extent.
void check_precision(const Points& points, const std::string& what) {
  const double distance = points.front().norm();
  double extent = 0.0;
  for (const Eigen::Vector3d& p : points) extent = std::max(extent, (p - points.front()).norm());
  if (extent > kNone * distance) return;
  if (extent <= kSame * distance) throw Error(what + ": all its points coincide");
  std::ostringstream text;
  text << what << ": its extent of " << extent << " is lost at its distance of " << distance
       << " from the origin; subtract one position from the points of both clouds";
  throw Error(text.str());
}

/// Throws Error if one point is so far away that nine of ten points coincide at the scale of all.
void check_extent(const Points& points, const std::string& what) {
  const Eigen::Vector3d median = median_of(points);
  std::vector<double> distances;
  for (const Eigen::Vector3d& p : points) distances.push_back((p - median).norm());
  const auto farthest = std::max_element(distances.begin(), distances.end());
  const double largest = *farthest;
  const auto index = farthest - distances.begin();
  const auto most = distances.begin() + std::ptrdiff_t(kMost * double(distances.size() - 1));
  std::nth_element(distances.begin(), most, distances.end());
  if (*most >= kLeastSpacing * largest) return;
  std::ostringstream text;
  text << what << ": nine of ten points lie within " << *most << " of their middle ("
       << median.transpose() << "), but point " << index + 1 << " is " << largest
       << " away; remove what is so far away";
  throw Error(text.str());
}

}  // namespace

CloudSpread spread_of(const Points& points) {
  CloudSpread spread;
  for (const Eigen::Vector3d& p : points) spread.center += p;
  spread.center /= static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    covariance.noalias() += (p - spread.center) * (p - spread.center).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance /
                                                              static_cast<double>(points.size()));
  spread.axes = solver.eigenvectors();
  spread.sigmas = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return spread;
}

double spacing_of(const Points& points) {
  if (points.size() < 2) return 0.0;
  WorkerPool alone(1);
  const TargetCloud cloud(points, LocalShape::kPoint, alone);
  const std::size_t step = std::max<std::size_t>(1, points.size() / kSample);
  std::vector<double> distances;
  for (std::size_t i = 0; i < points.size(); i += step) {
    const std::vector<int> found = cloud.nearest(points[i], 2);
    distances.push_back((points[found[1]] - points[found[0]]).norm());
  }
  const auto place =
      distances.begin() + std::ptrdiff_t(kSpacingQuantile * double(distances.size()));
  std::nth_element(distances.begin(), place, distances.end());
  return *place;
}

LocalShape local_shape(const Points& source, const Points& target) {
  const CloudSpread spreads[] = {spread_of(source), spread_of(target)};
  for (const CloudSpread& spread : spreads) {
    if (spread.sigmas[1] <= kNone * spread.radius()) return LocalShape::kPoint;
  }
  if (spreads[1].sigmas[0] > kNone * spreads[1].radius()) return LocalShape::kSurface;
  WorkerPool alone(1);
  const TargetCloud cloud(target, LocalShape::kPoint, alone);
  const std::size_t step = std::max<std::size_t>(1, target.size() / kSample);
  int in_line = 0, sampled = 0;
  for (std::size_t i = 0; i < target.size(); i += step, ++sampled) {
    Points neighbours;
    for (int k : cloud.nearest(target[i], TargetCloud::kNeighbours))
      neighbours.push_back(target[k]);
    const CloudSpread spread = spread_of(neighbours);
    in_line += spread.sigmas[1] < kInLine * spread.sigmas[2];
  }
  return 2 * in_line > sampled ? LocalShape::kCurve : LocalShape::kSurface;
}

Points subsample(const Points& points, double cell) {
  Eigen::Vector3d low = points.empty() ? Eigen::Vector3d::Zero() : points.front();
  for (const Eigen::Vector3d& p : points) low = low.cwiseMin(p);
  std::unordered_map<std::uint64_t, int> index;
  Points means;
  std::vector<double> counts;
  for (const Eigen::Vector3d& p : points) {
    const auto [it, added] = index.try_emplace(cell_of(p, low, cell), int(means.size()));
    if (added) {
      means.push_back(p);
      counts.push_back(1.0);
    } else {
      means[it->second] += p;
      counts[it->second] += 1.0;
    }
  }
  for (std::size_t i = 0; i < means.size(); ++i) means[i] /= counts[i];
  return means;
}

void check_cloud(const Points& points, const std::string& what) {
  if (points.size() < 3) {
    throw Error(what + " has " + std::to_string(points.size()) +
                (points.size() == 1 ? " point" : " points") + "; a registration needs at least 3");
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      throw Error(what + ": point " + std::to_string(i) + " (counted from 0) is not finite");
    }
  }
  check_precision(points, what);
  check_extent(points, what);
}

}  // namespace hybrid
