// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/io/text_reader.h"

namespace hybrid {

/// Index of the key of the vertex that word i names.
std::uint64_t vertex_in(const TextRow& row, std::size_t i);

/// x y angle from word i on.
SE2 planar_pose(const TextRow& row, std::size_t i);

/// x y z qx qy qz qw; the quaternion may have any length but 0.
SE3 pose_from_quaternion(const TextRow& row, std::size_t i);

/// x y z roll pitch yaw.
SE3 pose_from_angles(const TextRow& row, std::size_t i);

template <int n>
Eigen::Matrix<double, n, 1> point_in(const TextRow& row, std::size_t i) {
  Eigen::Matrix<double, n, 1> p;
  for (int axis = 0; axis < n; ++axis) p[axis] = row.coordinate(i + std::size_t(axis));
  return p;
}

/// Symmetric matrix from its upper triangle, row by row.
template <int n>
Eigen::Matrix<double, n, n> symmetric(const TextRow& row, std::size_t at) {
  Eigen::Matrix<double, n, n> m;
  for (int i = 0; i < n; ++i) {
    for (int j = i; j < n; ++j) m(i, j) = m(j, i) = row.number(at++);
  }
  return m;
}

/// The same in the order of TORO's EDGE2: I11 I12 I22 I33 I13 I23.
Eigen::Matrix3d symmetric_toro(const TextRow& row, std::size_t at);

using VisitRow = std::function<void(const TextRow&)>;
/// Reads all rows of a graph from its start.
using ReadGraphRows = std::function<void(const VisitRow&)>;

/// Where the lines of EDGE2 and EDGE3 of a file depart from TORO's.
struct GraphForms {
  bool hypotheses = false;  ///< a line has one hypothesis and as many words as no line of TORO
  bool by_rows = false;     ///< information of EDGE2 is definite row by row, not in TORO's order
};
GraphForms graph_forms(const ReadGraphRows& read);

/// The nearest matrix whose smallest eigenvalue is at least the root of epsilon times its largest.
Eigen::MatrixXd nearest_definite(const Eigen::MatrixXd& m);

}  // namespace hybrid
