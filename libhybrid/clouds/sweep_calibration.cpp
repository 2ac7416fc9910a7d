// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/sweep_calibration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "libhybrid/clouds/detail/distance_row.h"

namespace hybrid {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kTurn = 2 * 3.14159265358979323846;  // rad
/// Standard deviation of the change of the share from one cloud to the next: the times between
/// these vary.
constexpr double kShareChange = 0.003;
/// A lidar that turns has this share of the points, at least, that are in each sector in the mean.
constexpr std::size_t kSectors = 8;
constexpr double kLeastSector = 0.1;

std::size_t sector_of(const Eigen::Vector3f& direction) {
  const double turn = std::atan2(direction.y(), direction.x()) / kTurn + 0.5;
  return std::min(static_cast<std::size_t>(turn * kSectors), kSectors - 1);
}

bool is_all_around(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& sensor) {
  std::array<std::size_t, kSectors> counts{};
  for (const Eigen::Vector3f& point : points) {
    if (point.allFinite()) ++counts[sector_of(point - sensor)];
  }
  const double least = kLeastSector * static_cast<double>(points.size()) / kSectors;
  return std::all_of(counts.begin(), counts.end(),
                     [&](std::size_t count) { return static_cast<double>(count) > least; });
}

/// Normal equations of a pose and of the share, with residuals as they would be without shifts.
struct Equations {
  Matrix6 H = Matrix6::Zero();  // of the pose
  SweepCalibration::PoseShifts mixed = SweepCalibration::PoseShifts::Zero();
  Vector6 pose = Vector6::Zero();  // gradients
  double information = 0, share = 0;

  /// Rows of a Jacobian by the pose, with their information, shifts and residual.
  template <int N>
  void add(const Eigen::Matrix<double, N, 6>& J, const Eigen::Matrix<double, N, N>& weight,
           const Eigen::Matrix<double, N, 2>& shifts, const Eigen::Matrix<double, N, 1>& residual) {
    const Eigen::Matrix<double, N, 1> unshifted = residual - shifts.col(1);
    const Eigen::Matrix<double, 6, N> JW = J.transpose() * weight;
    H += JW * J;
    mixed += JW * shifts;
    pose += JW * unshifted;
    const Eigen::Matrix<double, 1, N> GW = shifts.col(0).transpose() * weight;
    information += GW.dot(shifts.col(0));
    share += GW.dot(unshifted);
  }
};

}  // namespace

Eigen::Vector3d SweepCalibration::derivative_at(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d d = point - sensor_;
  const double turned = std::atan2(d.y(), d.x()) / kTurn;
  return turned * (motion_.head<3>() + motion_.tail<3>().cross(point));
}

std::vector<Eigen::Vector3f> SweepCalibration::deskewed(std::vector<Eigen::Vector3f> points,
                                                        const Eigen::Vector3f& sensor,
                                                        const SE3& motion, bool is_at_once) {
  applies_ = !is_at_once && is_all_around(points, sensor);
  sensor_ = sensor.cast<double>();
  motion_ = motion.log();
  if (!applies_ || share_ == 0) return points;
  for (Eigen::Vector3f& point : points) {
    point += (share_ * derivative_at(point.cast<double>())).cast<float>();
  }
  return points;
}

SurfaceShifts SweepCalibration::own_shifts(const CloudPoint& point,
                                           const Eigen::Vector3d& normal) const {
  if (!applies_) return SurfaceShifts::Zero();
  const double shift = normal.dot(derivative_at(point.position.cast<double>()));
  return Eigen::Vector2d(shift, share_ * shift).cast<float>();
}

std::vector<SurfaceShifts> SweepCalibration::shifts_of(
    const std::vector<CloudPoint>& points) const {
  std::vector<SurfaceShifts> out;
  out.reserve(points.size());
  for (const CloudPoint& point : points) {
    out.push_back(own_shifts(point, point.normal.cast<double>()));
  }
  return out;
}

std::vector<SurfaceShifts> shifts_at(const SweepCalibration::PoseShifts& pose,
                                     const std::vector<CloudPoint>& points,
                                     std::vector<SurfaceShifts> shifts) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const CloudPoint& point = points[i];
    const Vector6 row = distance_row(point.normal.cast<double>(), point.position.cast<double>());
    shifts[i] += (pose.transpose() * row).cast<float>();
  }
  return shifts;
}

SweepCalibration::PoseShifts SweepCalibration::learn(const std::vector<CloudPoint>& points,
                                                     const CloudSurfaces& map,
                                                     const CloudAlignment& found,
                                                     const Prediction& predicted) {
  if (!applies_ && share_ == 0) return PoseShifts::Zero();  // nothing has moved any cloud so far
  const Eigen::Matrix3d R = found.pose.rotation().matrix();
  Equations equations;
  equations.add<6>(Matrix6::Identity(), predicted.information, -predicted.shifts,
                   predicted.pose.between(found.pose).log());
  for (const CloudPoint& point : points) {
    if (!point.has_normal()) continue;
    const Eigen::Vector3d p = point.position.cast<double>();
    const Eigen::Vector3f at = (found.pose * p).cast<float>();
    const Eigen::Vector3f facing = (R * point.normal.cast<double>()).cast<float>();
    const CloudPoint* other = map.nearest(at, facing, map.spacing());
    if (other == nullptr) continue;
    const double residual = other->normal.dot(at - other->position);
    const Eigen::Vector3d normal = R.transpose() * other->normal.cast<double>();
    const SurfaceShifts shifts = own_shifts(point, normal) - map.shifts_of(*other);
    using Scalar = Eigen::Matrix<double, 1, 1>;
    equations.add<1>(distance_row(normal, p).transpose(),
                     Scalar(pairing_weight(residual, found.sigma, map.spacing())),
                     shifts.cast<double>().transpose(), Scalar(residual));
  }
  const PoseShifts shifts = -equations.H.ldlt().solve(equations.mixed);
  if (!shifts.allFinite()) return PoseShifts::Zero();
  const double known = 1 / (sigma_ * sigma_ + kShareChange * kShareChange);
  const double told = equations.information + equations.mixed.col(0).dot(shifts.col(0));
  const double gradient = equations.share + shifts.col(0).dot(equations.pose);
  share_ = (known * share_ - gradient) / (known + told);
  sigma_ = 1 / std::sqrt(known + told);
  return shifts;
}

}  // namespace hybrid
