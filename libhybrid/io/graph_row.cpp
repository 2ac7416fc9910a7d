// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/detail/graph_row.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "libhybrid/pose_graph/vertex_id.h"

namespace hybrid {
namespace {

bool is_definite(const Eigen::Matrix3d& information) {
  return information.llt().info() == Eigen::Success;
}

}  // namespace

std::uint64_t vertex_in(const TextRow& row, std::size_t i) {
  const std::int64_t id = row.id(i, std::numeric_limits<std::int64_t>::max());
  const std::optional<std::uint64_t> index = vertex_index(id);
  if (index) return *index;
  row.fail(i, "'" + std::string(row[i]) + "' is larger than " + std::to_string(kLargestPlainId) +
                  " and no Symbol of GTSAM of a number below 2^40");
}

SE2 planar_pose(const TextRow& row, std::size_t i) {
  return {row.coordinate(i), row.coordinate(i + 1), row.coordinate(i + 2)};
}

SE3 pose_from_quaternion(const TextRow& row, std::size_t i) {
  Eigen::Quaterniond q(row.coordinate(i + 6), row.coordinate(i + 3), row.coordinate(i + 4),
                       row.coordinate(i + 5));
  const double norm = q.coeffs().norm();
  if (!(norm > 1e-6)) row.fail(i + 3, "a quaternion that has no direction");
  q.coeffs() /= norm;
  return {point_in<3>(row, i), q};
}

SE3 pose_from_angles(const TextRow& row, std::size_t i) {
  const Eigen::Quaterniond q = Eigen::AngleAxisd(row.coordinate(i + 5), Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(row.coordinate(i + 4), Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(row.coordinate(i + 3), Eigen::Vector3d::UnitX());
  return {point_in<3>(row, i), q};
}

Eigen::Matrix3d symmetric_toro(const TextRow& row, std::size_t at) {
  constexpr std::size_t kPlace[3][3] = {{0, 1, 4}, {1, 2, 5}, {4, 5, 3}};
  Eigen::Matrix3d m;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m(i, j) = row.number(at + kPlace[i][j]);
  }
  return m;
}

GraphForms graph_forms(const ReadGraphRows& read) {
  GraphForms forms;
  bool all_toro = true, all_rows = true;
  read([&](const TextRow& row) {
    const bool planar = row[0] == "EDGE2";
    if ((planar && row.size() == 9) || (row[0] == "EDGE3" && row.size() == 12)) {
      forms.hypotheses = true;
    }
    if (!planar || row.size() != 12 || !all_rows) return;
    all_toro = all_toro && is_definite(symmetric_toro(row, 6));
    all_rows = is_definite(symmetric<3>(row, 6));
  });
  forms.by_rows = all_rows && !all_toro;
  return forms;
}

Eigen::MatrixXd nearest_definite(const Eigen::MatrixXd& m) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(m);
  const Eigen::VectorXd& values = eigen.eigenvalues();
  const double least = std::sqrt(std::numeric_limits<double>::epsilon()) * values.maxCoeff();
  const Eigen::MatrixXd& V = eigen.eigenvectors();
  const Eigen::MatrixXd near = V * values.cwiseMax(least).asDiagonal() * V.transpose();
  return 0.5 * (near + near.transpose());
}

}  // namespace hybrid
