// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_alignment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "libhybrid/clouds/detail/distance_row.h"
#include "libhybrid/core/quantile.h"
#include "libhybrid/scans/direction_errors.h"

namespace hybrid {
namespace {

/// The radius of the search for counterparts shrinks by this factor per iteration, down to so many
/// spacings of the map.
constexpr double kRadiusShrink = 0.7;
constexpr double kLeastRadius = 1.0;
/// The scatter of returns around surfaces: of a lidar at least [m], and at most this share of the
/// spacing.
constexpr double kLeastSigma = 0.01;
constexpr double kMostSigma = 0.5;
/// The loss is that of Geman and McClure beyond this many sigmas.
constexpr double kLossWidth = 2.5;
/// A point lies on a surface within this share of the spacing of the map.
constexpr double kOnSurface = 0.5;
/// Along a surface, errors of returns and of the map are one error over this length [m], so that
/// closer points count as less than one.
constexpr double kCorrelationLength = 0.3;
/// Steps below this [m], [rad] end the iteration; no step is longer than the other.
constexpr double kSmallStep = 2e-4;
constexpr double kLongStep = 0.5;
/// Information that each direction has without any point.
constexpr double kLeastInformation = 1e-3;
/// Median of the absolute values of a normal variable of unit variance.
constexpr double kMedianOfNormal = 0.6745;
/// Errors that all points of an alignment share [m], [rad], and standard deviations of what it does
/// not tell.
constexpr double kSharedTranslation = 0.005;
constexpr double kSharedRotation = 0.001;
constexpr double kUnknownTranslation = 20;
constexpr double kUnknownRotation = 2;

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// What a point counts by its distance from its surface [m]: 1 on it, 0 where it lies on none.
double support_at(double residual, double spacing) {
  return std::max(0.0, 1 - std::pow(residual / (kOnSurface * spacing), 2));
}

struct Pairing {
  Eigen::Vector3d normal, point;  // in the frame of the points
  double residual = 0;

  Vector6 jacobian() const { return distance_row(normal, point); }
};

std::vector<Pairing> pairings_at(const std::vector<CloudPoint>& points, const CloudSurfaces& map,
                                 double radius, CloudAlignment& result) {
  std::vector<Pairing> pairings;
  pairings.reserve(points.size());
  const Eigen::Matrix3d R = result.pose.rotation().matrix();
  const Eigen::Matrix3f Rf = R.cast<float>();
  const Eigen::Vector3f t = result.pose.translation().cast<float>();
  std::size_t inliers = 0, used = 0;
  double support = 0;
  for (const CloudPoint& point : points) {
    if (!point.has_normal()) continue;
    ++used;
    const Eigen::Vector3f position = Rf * point.position + t;
    const CloudPoint* other = map.nearest(position, Rf * point.normal, radius);
    if (other == nullptr) continue;
    const double residual = other->normal.dot(position - other->position);
    pairings.push_back(
        {R.transpose() * other->normal.cast<double>(), point.position.cast<double>(), residual});
    const double counts = support_at(residual, map.spacing());
    inliers += counts > 0 ? 1 : 0;
    support += counts;
  }
  result.inliers = used > 0 ? double(inliers) / double(used) : 0;
  result.support = used > 0 ? support / double(used) : 0;
  return pairings;
}

double robust_sigma(const std::vector<Pairing>& pairings, double most) {
  if (pairings.empty()) return most;
  std::vector<double> sizes(pairings.size());
  std::transform(pairings.begin(), pairings.end(), sizes.begin(),
                 [](const Pairing& pairing) { return std::abs(pairing.residual); });
  return std::clamp(median(std::move(sizes)) / kMedianOfNormal, std::min(kLeastSigma, most), most);
}

/// Information of the pairings without what errors of the directions of surfaces seem to add: the
/// walls of a tunnel alone do not tell the place along it.
Matrix6 information_of(const std::vector<Pairing>& pairings, double sigma, double spacing) {
  Matrix6 H = kLeastInformation * Matrix6::Identity(), F = Matrix6::Zero();
  for (const Pairing& pairing : pairings) {
    const double weight = pairing_weight(pairing.residual, sigma, spacing);
    H.selfadjointView<Eigen::Lower>().rankUpdate(pairing.jacobian(), weight);
    const Eigen::Vector3d across = pairing.normal.unitOrthogonal();
    for (const Eigen::Vector3d& t : {across, Eigen::Vector3d(pairing.normal.cross(across))}) {
      F.selfadjointView<Eigen::Lower>().rankUpdate(distance_row(t, pairing.point),
                                                   weight * kDirectionError * kDirectionError);
    }
  }
  H.triangularView<Eigen::StrictlyUpper>() = H.transpose();
  F.triangularView<Eigen::StrictlyUpper>() = F.transpose();
  return without_direction_errors<6>(share_of_surfaces<6>(H, F), H);
}

}  // namespace

double support_of(const CloudPoint& point, const CloudSurfaces& map) {
  if (!point.has_normal()) return 0;
  const CloudPoint* other = map.nearest(point.position, point.normal, kLeastRadius * map.spacing());
  if (other == nullptr) return 0;
  return support_at(other->normal.dot(point.position - other->position), map.spacing());
}

double pairing_weight(double residual, double sigma, double spacing) {
  const double r = residual / (kLossWidth * sigma);
  const double root = 1 / (1 + r * r);
  const double share = std::min(1.0, std::pow(spacing / kCorrelationLength, 2));
  return share * root * root / (sigma * sigma);
}

CloudAlignment align(const std::vector<CloudPoint>& points, const CloudSurfaces& map,
                     const SE3& start, const CloudAlignmentOptions& options) {
  CloudAlignment result;
  result.pose = start;
  const double most_sigma = kMostSigma * map.spacing();
  result.sigma = most_sigma;
  if (points.empty() || map.points().empty()) return result;
  const double least_radius = kLeastRadius * map.spacing();
  double radius = map.most_radius();
  std::vector<Pairing> pairings;
  for (int i = 0; i < options.max_iterations; ++i) {
    pairings = pairings_at(points, map, radius, result);
    result.sigma = robust_sigma(pairings, most_sigma);
    Matrix6 H = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    for (const Pairing& pairing : pairings) {
      const double weight = pairing_weight(pairing.residual, result.sigma, map.spacing());
      const Vector6 jacobian = pairing.jacobian();
      H.selfadjointView<Eigen::Lower>().rankUpdate(jacobian, weight);
      g += weight * pairing.residual * jacobian;
    }
    H.triangularView<Eigen::StrictlyUpper>() = H.transpose();
    Matrix6 A = H + options.prior;
    A.diagonal().array() += kLeastInformation;
    const Vector6 off = start.between(result.pose).log();
    Vector6 step = -A.llt().solve(g + options.prior * off);
    if (!step.allFinite()) break;
    step *= std::min(1.0, kLongStep / std::max(step.norm(), 1e-9));
    result.pose = result.pose * SE3::exp(step);
    result.pose.normalize();
    const bool smallest = radius <= least_radius;
    radius = std::max(radius * kRadiusShrink, least_radius);
    if (smallest && step.cwiseAbs().maxCoeff() < kSmallStep) break;
  }
  if (options.with_information) {
    result.information = information_of(pairings, result.sigma, map.spacing());
  }
  return result;
}

Matrix6 alignment_covariance(const CloudAlignment& alignment) {
  Vector6 unknown, shared;
  unknown << Eigen::Vector3d::Constant(kUnknownTranslation),
      Eigen::Vector3d::Constant(kUnknownRotation);
  shared << Eigen::Vector3d::Constant(kSharedTranslation),
      Eigen::Vector3d::Constant(kSharedRotation);
  shared /= std::max(alignment.inliers, 0.1);
  Matrix6 information = alignment.information;
  information.diagonal() += unknown.cwiseAbs2().cwiseInverse();
  Matrix6 covariance = information.inverse();
  covariance.diagonal() += shared.cwiseAbs2();
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace hybrid
