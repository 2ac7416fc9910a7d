// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_alignment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/core/quantile.h"
#include "libhybrid/scans/direction_errors.h"

namespace hybrid {
namespace {

/// The radius of the search for counterparts shrinks by this factor per iteration, down to this
/// [m].
constexpr double kRadiusShrink = 0.7;
constexpr double kLeastRadius = 0.15;
/// The scatter of returns around surfaces is between the resolution of a sensor and the roughness
/// of a wall [m].
constexpr double kLeastSigma = 0.015;
constexpr double kMostSigma = 0.1;
/// The loss is that of Geman and McClure beyond this many sigmas.
constexpr double kLossWidth = 2.5;
/// Steps below this [m], [rad] end the iteration.
constexpr double kSmallStep = 2e-4;
/// Information that each direction has without any point.
constexpr double kLeastInformation = 1e-3;
/// A point lies on a surface within this distance [m].
constexpr double kOnSurface = 0.1;
/// Median of the absolute values of a normal variable of unit variance.
constexpr double kMedianOfNormal = 0.6745;

struct Pairing {
  Eigen::Vector3d jacobian;
  Eigen::Vector3d along;  // the same for a normal turned by a right angle
  double residual = 0.0;
  double weight = 0.0;
  double direction_error = 0.0;  // of the surface [rad]
};

/// The counterparts of the points at the pose of `result`; counts those that lie on a surface.
std::vector<Pairing> pairings_at(const std::vector<SurfacePoint>& points, const SurfaceMap& map,
                                 double radius, double correlation, ScanAlignment& result) {
  std::vector<Pairing> pairings;
  pairings.reserve(points.size());
  int on_surface = 0;
  result.support = 0.0;
  const SE2& pose = result.pose;
  const SO2 back = pose.rotation().inverse();
  for (const SurfacePoint& point : points) {
    const Eigen::Vector2d position = pose * point.position;
    const Eigen::Vector2d normal = pose.rotation() * point.normal;
    const SurfaceMap::Surfel* surfel = map.nearest(position, normal, radius);
    if (surfel == nullptr) continue;
    const double residual = surfel->normal.dot(position - surfel->position);
    const Eigen::Vector2d n = back * surfel->normal;
    const Eigen::Vector2d& p = point.position;
    pairings.push_back({{n.x(), n.y(), n.y() * p.x() - n.x() * p.y()},
                        {-n.y(), n.x(), n.x() * p.x() + n.y() * p.y()},
                        residual,
                        std::min(1.0, point.length / correlation),
                        kDirectionError / std::sqrt(surfel->count)});
    if (std::abs(residual) >= kOnSurface) continue;
    ++on_surface;
    result.support += pairings.back().weight * (1.0 - std::pow(residual / kOnSurface, 2));
  }
  result.inliers = double(on_surface) / double(points.size());
  return pairings;
}

double robust_sigma(const std::vector<Pairing>& pairings) {
  if (pairings.empty()) return kMostSigma;
  std::vector<double> sizes(pairings.size());
  std::transform(pairings.begin(), pairings.end(), sizes.begin(),
                 [](const Pairing& pairing) { return std::abs(pairing.residual); });
  return std::clamp(median(std::move(sizes)) / kMedianOfNormal, kLeastSigma, kMostSigma);
}

}  // namespace

ScanAlignment align(const std::vector<SurfacePoint>& points, const SurfaceMap& map,
                    const SE2& start, const AlignmentOptions& options) {
  ScanAlignment result;
  result.pose = start;
  result.sigma = kMostSigma;
  if (points.empty() || map.empty()) return result;
  double radius = std::min(options.radius, SurfaceMap::cell_size());
  for (int i = 0; i < options.max_iterations; ++i) {
    const std::vector<Pairing> pairings =
        pairings_at(points, map, radius, options.correlation_length, result);
    result.sigma = robust_sigma(pairings);
    Eigen::Matrix3d H = kLeastInformation * Eigen::Matrix3d::Identity();
    Eigen::Matrix3d F = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const Pairing& pairing : pairings) {
      const double r = pairing.residual / (kLossWidth * result.sigma);
      const double root = 1.0 / (1.0 + r * r);
      const double weight = pairing.weight * root * root / (result.sigma * result.sigma);
      H += weight * pairing.jacobian * pairing.jacobian.transpose();
      F +=
          weight * std::pow(pairing.direction_error, 2) * pairing.along * pairing.along.transpose();
      g += weight * pairing.residual * pairing.jacobian;
    }
    const Eigen::Matrix3d share = share_of_surfaces<3>(H, F);
    const Eigen::Matrix3d information = without_direction_errors<3>(share, H);
    const Eigen::Matrix3d A = information + options.prior;
    const Eigen::Vector3d off = start.between(result.pose).log();
    Eigen::Vector3d step = -A.llt().solve(share * g + options.prior * off);
    if (!step.allFinite()) break;
    step *= std::min(1.0, 0.5 / std::max(step.norm(), 1e-9));
    result.pose = result.pose * SE2::exp(step);
    result.pose.normalize();
    const bool smallest = radius <= kLeastRadius;
    radius = std::max(radius * kRadiusShrink, kLeastRadius);
    const bool last =
        (smallest && step.cwiseAbs().maxCoeff() < kSmallStep) || i + 1 == options.max_iterations;
    if (!last) continue;
    result.information = information;
    break;
  }
  return result;
}

}  // namespace hybrid
