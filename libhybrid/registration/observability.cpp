// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/registration/observability.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace hybrid {
namespace {

/// Mean square inclination of estimated normals along motions that leave a surface as it is, e.g.
/// rotations of a sphere.
constexpr double kNormalsOfNothing = 1e-3;

std::string text(const Eigen::Vector3d& v) {
  char buffer[96];
  std::snprintf(buffer, sizeof(buffer), "(%.4g, %.4g, %.4g)", v.x() + 0.0, v.y() + 0.0,
                v.z() + 0.0);
  return buffer;
}

/// Weights of the well-measured part of a pair: all of r, its part along the normal, or its part
/// across the tangent.
MatchWeights certain_part(LocalShape shape) {
  MatchWeights weights({1.0, 1.0, 1.0}, shape);
  weights.all = shape == LocalShape::kSurface ? 0.0 : 1.0;
  weights.directed = shape == LocalShape::kPoint ? 0.0 : shape == LocalShape::kSurface ? 1.0 : -1.0;
  return weights;
}

double threshold(const Alignment& alignment, double radius, double spacing) {
  const double noise = alignment.noise().across;
  if (alignment.shape() == LocalShape::kPoint) {
    return std::max(1e-9, std::pow(noise / radius, 2));  // levers shorter than the noise
  }
  // A direction fitted to the neighbours of a point errs by about noise / (spacing sqrt(12)).
  return std::max(kNormalsOfNothing, std::pow(noise / spacing, 2) / 3.0);
}

/// Describes a null space, such as the threefold one of a plane, whose basis is an arbitrary
/// mixture of its motions: pure translations first, then rotations without a part along these.
std::vector<FreeMotion> describe(const Eigen::MatrixXd& basis, const Eigen::Vector3d& center,
                                 double radius) {
  std::vector<FreeMotion> motions;
  // Combinations of the basis without rotation are translations.
  const Eigen::MatrixXd turns = basis.bottomRows<3>();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(turns.transpose() * turns);
  for (int i = 0; i < basis.cols(); ++i) {
    const Eigen::VectorXd v = basis * solver.eigenvectors().col(i);
    FreeMotion motion;
    const Eigen::Vector3d move = v.head<3>() * radius, turn = v.tail<3>();
    motion.is_rotation = turn.norm() > 0.1;
    motion.direction = (motion.is_rotation ? turn : move).normalized();
    if (motion.is_rotation) motion.through = center + turn.cross(move) / turn.squaredNorm();
    // Of the two signs, the one whose largest entry is positive.
    Eigen::Index largest = 0;
    motion.direction.cwiseAbs().maxCoeff(&largest);
    if (motion.direction[largest] < 0.0) motion.direction = -motion.direction;
    motions.push_back(motion);
  }
  return motions;
}

}  // namespace

std::string to_string(const FreeMotion& motion) {
  if (!motion.is_rotation) return "translation along " + text(motion.direction);
  return "rotation about the axis " + text(motion.direction) + " through " + text(motion.through);
}

std::vector<FreeMotion> free_motions(const Alignment& alignment, const SE3& T_target_source,
                                     const Eigen::Vector3d& center, double radius, double spacing) {
  const Eigen::Vector3d pivot = T_target_source * center;
  Alignment::Vector6 scale;
  scale << Eigen::Vector3d::Ones(), Eigen::Vector3d::Constant(1.0 / radius);
  Alignment::Matrix6 H =
      alignment.system(T_target_source, certain_part(alignment.shape()), pivot).H;
  H = scale.asDiagonal() * H * scale.asDiagonal() / std::max(1, alignment.inliers());
  const Eigen::SelfAdjointEigenSolver<Alignment::Matrix6> solver(H);
  const double least = threshold(alignment, radius, spacing);
  int count = 0;
  while (count < 6 && solver.eigenvalues()[count] < least) ++count;
  if (count == 0) return {};
  // In these units a turn by 1 / radius moves as far as a translation by 1.
  const Eigen::MatrixXd basis = solver.eigenvectors().leftCols(count);
  return describe(basis, pivot, radius);
}

Alignment::Matrix6 covariance_of(const Alignment& alignment, const SE3& T_target_source,
                                 const Eigen::Vector3d& center) {
  const Eigen::Vector3d pivot = T_target_source * center;
  const MatchWeights weights(alignment.noise(), alignment.shape());
  const Alignment::Matrix6 H = alignment.system(T_target_source, weights, pivot).H;
  // A step (rho, phi) of the tangent turns by R phi and moves the pivot by R rho + R phi x (pivot -
  // t).
  const Eigen::Matrix3d R = T_target_source.rotation().matrix();
  Alignment::Matrix6 A = Alignment::Matrix6::Zero();
  A.topLeftCorner<3, 3>() = R;
  A.bottomRightCorner<3, 3>() = R;
  A.topRightCorner<3, 3>() = -hat(pivot - T_target_source.translation()) * R;
  const Alignment::Matrix6 information = A.transpose() * H * A;
  return information.ldlt().solve(Alignment::Matrix6::Identity());
}

}  // namespace hybrid
