// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Cholesky>
#include <random>
#include <vector>

#include "libhybrid/maps/map_record.h"

namespace hybrid {

/// Places of landmarks, at least a metre apart, in a square or cube of this side [m].
inline std::vector<Eigen::Vector3d> scattered(int count, double side, bool is_3d,
                                              std::mt19937_64& random) {
  std::uniform_real_distribution<double> along(0, side);
  std::vector<Eigen::Vector3d> out;
  while (static_cast<int>(out.size()) < count) {
    const Eigen::Vector3d p(along(random), along(random), is_3d ? along(random) : 0.0);
    bool near = false;
    for (const Eigen::Vector3d& q : out) near = near || (p - q).norm() < 1;
    if (!near) out.push_back(p);
  }
  return out;
}

/// A covariance as a robot leaves it that drives past landmarks: what it knows of each, and a
/// drift that those seen later share.
inline Eigen::MatrixXd drifting_covariance(int count, int dim, double own, double drift) {
  Eigen::MatrixXd C = own * own * Eigen::MatrixXd::Identity(dim * count, dim * count);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      C.block(dim * i, dim * j, dim, dim).diagonal().array() +=
          drift * drift * (std::min(i, j) + 1);
    }
  }
  return C;
}

/// A map of places as T sees them, with an error drawn from its covariance.
inline MapRecord stored_map(const std::vector<Eigen::Vector3d>& places,
                            const Eigen::Isometry3d& T_map_world, bool is_3d, double own,
                            double drift, std::mt19937_64& random) {
  MapRecord map;
  map.is_3d = is_3d;
  const int n = static_cast<int>(places.size()), dim = map.dim();
  const Eigen::MatrixXd C = drifting_covariance(n, dim, own, drift);
  std::normal_distribution<double> normal;
  Eigen::VectorXd white(dim * n);
  for (double& v : white) v = normal(random);
  const Eigen::VectorXd error = Eigen::LLT<Eigen::MatrixXd>(C).matrixL() * white;
  for (int i = 0; i < n; ++i) {
    MapLandmark l;
    l.id = i;
    l.position = T_map_world * places[static_cast<std::size_t>(i)];
    l.position.head(dim) += error.segment(dim * i, dim);
    l.covariance.topLeftCorner(dim, dim) = C.block(dim * i, dim * i, dim, dim);
    l.existence = 5;
    l.session = 1;
    map.landmarks.push_back(l);
  }
  map.prior = sparsify(C, dim);
  MapSession session;
  session.id = 1;
  session.mode = "build";
  session.complete = true;
  session.keyframes.resize(2);
  map.sessions.push_back(session);
  return map;
}

inline Eigen::Isometry3d motion(double x, double y, double yaw) {
  return Eigen::Translation3d(x, y, 0) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
}

}  // namespace hybrid
