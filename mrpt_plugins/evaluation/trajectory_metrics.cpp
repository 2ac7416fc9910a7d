// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/trajectory_metrics.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegreesPerRadian = 180.0 / M_PI;

Eigen::Vector3d position(const CPose3D& pose) {
  return {pose.x(), pose.y(), pose.z()};
}

Eigen::Matrix3d rotation(const CPose3D& pose) {
  return pose.getRotationMatrix().asEigen();
}

/// Rotation vector, rad. Eigen's atan2 form keeps its accuracy from zero to pi.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd a{Eigen::Quaterniond(R)};
  return a.angle() * a.axis();
}

bool is_planar(const CPose3D& pose) {
  return std::abs(pose.z()) < 1e-9 && rotation(pose)(2, 2) > 1 - 1e-12;
}

/// The rotation that minimises the squared distances between the centred estimates, rotated, and
/// the truth, from their cross covariance sum truth * estimate'. D makes it a rotation where a
/// reflection would fit better.
template <int kDim>
Eigen::Matrix<double, kDim, kDim> best_rotation(const Eigen::Matrix<double, kDim, kDim>& cross) {
  using Square = Eigen::Matrix<double, kDim, kDim>;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Square U = svd.matrixU();
  const Square V = svd.matrixV();
  Square D = Square::Identity();
  if ((U * V.transpose()).determinant() < 0) D(kDim - 1, kDim - 1) = -1;
  return U * D * V.transpose();
}

/// First index at which the path is `distance` longer than at `start`; the size if there is none.
std::size_t end_of_stretch(const std::vector<double>& travelled, std::size_t start,
                           double distance) {
  const double goal = travelled[start] + distance;
  const auto from = travelled.begin() + static_cast<std::ptrdiff_t>(start);
  return static_cast<std::size_t>(std::lower_bound(from, travelled.end(), goal) -
                                  travelled.begin());
}

}  // namespace

std::vector<PosePair> pair_by_time(const Trajectory& estimate, const Trajectory& truth,
                                   double max_difference) {
  std::vector<PosePair> pairs;
  for (const TimedPose& e : estimate) {
    const auto after =
        std::lower_bound(truth.begin(), truth.end(), e.time,
                         [](const TimedPose& t, double time) { return t.time < time; });
    auto nearest = after;
    if (after == truth.end() ||
        (after != truth.begin() && e.time - (after - 1)->time <= after->time - e.time)) {
      nearest = after == truth.begin() ? after : after - 1;
    }
    if (nearest == truth.end() || std::abs(nearest->time - e.time) > max_difference) continue;
    pairs.push_back({e.pose, nearest->pose});
  }
  return pairs;
}

TrajectoryErrors trajectory_errors(const std::vector<PosePair>& pairs) {
  if (pairs.empty()) return {kNaN, kNaN, kNaN, kNaN, kNaN};
  TrajectoryErrors e;
  for (const PosePair& p : pairs) {
    const double metres = (position(p.truth) - position(p.estimate)).norm();
    const double degrees =
        kDegreesPerRadian *
        rotation_vector(rotation(p.estimate).transpose() * rotation(p.truth)).norm();
    e.mean_m += metres;
    e.rmse_m += metres * metres;
    e.max_m = std::max(e.max_m, metres);
    e.rotation_mean_deg += degrees;
    e.rotation_rmse_deg += degrees * degrees;
  }
  const auto n = static_cast<double>(pairs.size());
  e.mean_m /= n;
  e.rmse_m = std::sqrt(e.rmse_m / n);
  e.rotation_mean_deg /= n;
  e.rotation_rmse_deg = std::sqrt(e.rotation_rmse_deg / n);
  return e;
}

CPose3D alignment(const std::vector<PosePair>& pairs) {
  if (pairs.empty()) return {};
  Eigen::Vector3d mean_estimate = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_truth = Eigen::Vector3d::Zero();
  bool planar = true;
  for (const PosePair& p : pairs) {
    mean_estimate += position(p.estimate) / static_cast<double>(pairs.size());
    mean_truth += position(p.truth) / static_cast<double>(pairs.size());
    planar = planar && is_planar(p.estimate) && is_planar(p.truth);
  }
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  for (const PosePair& p : pairs) {
    cross += (position(p.truth) - mean_truth) * (position(p.estimate) - mean_estimate).transpose();
  }
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  if (planar) {
    R.topLeftCorner<2, 2>() = best_rotation<2>(cross.topLeftCorner<2, 2>());
  } else {
    R = best_rotation<3>(cross);
  }
  const Eigen::Vector3d t = mean_truth - R * mean_estimate;
  return {mrpt::math::CMatrixDouble33(R),
          mrpt::math::CVectorFixedDouble<3>(mrpt::math::TPoint3D(t.x(), t.y(), t.z()))};
}

TrajectoryReport trajectory_report(const std::vector<PosePair>& pairs, TruthContent content) {
  const CPose3D T_truth_estimate = alignment(pairs);
  std::vector<PosePair> moved = pairs;
  for (PosePair& p : moved) p.estimate = T_truth_estimate + p.estimate;
  TrajectoryReport report{trajectory_errors(pairs), trajectory_errors(moved), {}, pairs.size()};
  if (content == TruthContent::kPositions) {
    for (TrajectoryErrors* e : {&report.unaligned, &report.aligned}) {
      e->rotation_mean_deg = e->rotation_rmse_deg = kNaN;
    }
    return report;
  }
  for (const RelativeError& e : relative_errors(pairs, {1, 10, 100, 500})) {
    if (e.stretches > 0) report.relative.push_back(e);
  }
  return report;
}

std::vector<RelativeError> relative_errors(const std::vector<PosePair>& pairs,
                                           const std::vector<double>& distances_m) {
  std::vector<double> travelled(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    travelled[i] =
        travelled[i - 1] + (position(pairs[i].truth) - position(pairs[i - 1].truth)).norm();
  }
  std::vector<RelativeError> out;
  for (const double distance : distances_m) {
    RelativeError e;
    e.distance_m = distance;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const std::size_t j = end_of_stretch(travelled, i, distance);
      if (j == pairs.size()) break;
      const CPose3D error =
          (pairs[j].truth - pairs[i].truth) - (pairs[j].estimate - pairs[i].estimate);
      ++e.stretches;
      e.translation_m += position(error).norm();
      e.rotation_deg += kDegreesPerRadian * rotation_vector(rotation(error)).norm();
    }
    const double n = e.stretches == 0 ? kNaN : static_cast<double>(e.stretches);
    e.translation_m /= n;
    e.rotation_deg /= n;
    out.push_back(e);
  }
  return out;
}

Eigen::Matrix<double, 6, 1> tangent_error(const PosePair& pair) {
  const CPose3D error = pair.truth - pair.estimate;
  const Eigen::Vector3d w = rotation_vector(rotation(error));
  const double angle = w.norm();
  Eigen::Matrix3d W;
  W << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  const double quadratic =
      angle < 1e-4 ? 1.0 / 12.0 : (1 - 0.5 * angle / std::tan(0.5 * angle)) / (angle * angle);
  Eigen::Matrix<double, 6, 1> e;
  e << (Eigen::Matrix3d::Identity() - 0.5 * W + quadratic * W * W) * position(error), w;
  return e;
}

double mean_nees(const std::vector<PosePair>& pairs,
                 const std::vector<Eigen::MatrixXd>& covariances) {
  if (pairs.size() != covariances.size()) {
    throw std::invalid_argument(
        fmt::format("{} pose pairs but {} covariances", pairs.size(), covariances.size()));
  }
  double sum = 0;
  double freedoms = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::MatrixXd& P = covariances[i];
    if (P.rows() != P.cols() || (P.rows() != 3 && P.rows() != 6)) {
      throw std::invalid_argument(
          fmt::format("covariance {} is {}x{}; a pose needs 3x3 or 6x6", i, P.rows(), P.cols()));
    }
    const Eigen::Matrix<double, 6, 1> e = tangent_error(pairs[i]);
    Eigen::VectorXd error = e;
    if (P.rows() == 3) error = Eigen::Vector3d(e[0], e[1], e[5]);
    sum += error.dot(P.ldlt().solve(error));
    freedoms += static_cast<double>(P.rows());
  }
  return freedoms > 0 ? sum / freedoms : kNaN;
}

}  // namespace hybrid
