// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/variable.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace hybrid {
namespace {

constexpr double kStep = 1e-5;  // of central differences, for tangents of order 1

template <class Group>
void retract_group(const double* x, const double* delta, double* out) {
  Group g = Group::load(x) * Group::exp(Eigen::Map<const typename Group::Tangent>(delta));
  g.normalize();
  g.store(out);
}

template <class Group>
void normalize_group(double* x) {
  Group g = Group::load(x);
  if (g.is_unit()) return;
  g.normalize();
  g.store(x);
}

template <class Group>
void local_group(const double* x, const double* y, double* delta) {
  Eigen::Map<typename Group::Tangent>{delta} = (Group::load(x).inverse() * Group::load(y)).log();
}

/// Derivative, by central differences, of the `count` numbers that fill(x, numbers) writes with
/// respect to the tangent at x.
template <class Fill>
Eigen::MatrixXd central_differences(VariableType type, const double* x, int count,
                                    const Fill& fill) {
  Eigen::MatrixXd J(count, type.dim);
  Eigen::VectorXd delta(type.dim), plus(count), minus(count);
  std::vector<double> moved(type.size);
  for (int d = 0; d < type.dim; ++d) {
    delta.setZero();
    delta[d] = kStep;
    retract(type, x, delta.data(), moved.data());
    fill(moved.data(), plus.data());
    delta[d] = -kStep;
    retract(type, x, delta.data(), moved.data());
    fill(moved.data(), minus.data());
    J.col(d) = (plus - minus) / (2 * kStep);
  }
  return J;
}

/// Derivative of the storage (cos, sin) with respect to the angle.
Eigen::Vector2d turned(const double* x) {
  return {-x[1], x[0]};
}

/// Derivative of the quaternion (x, y, z, w) of q exp(delta) with respect to delta at zero.
Eigen::Matrix<double, 4, 3> turned_quaternion(const double* q) {
  Eigen::Matrix<double, 4, 3> J;
  J << q[3], -q[2], q[1], q[2], q[3], -q[0], -q[1], q[0], q[3], -q[0], -q[1], -q[2];
  return 0.5 * J;
}

}  // namespace

bool VariableType::same_manifold(const Manifold& a, const Manifold& b) {
  return std::strcmp(a.name, b.name) == 0;
}

std::string to_string(VariableType type) {
  switch (type.kind) {
    case VariableKind::kSO2:
      return "SO2";
    case VariableKind::kSE2:
      return "SE2";
    case VariableKind::kSO3:
      return "SO3";
    case VariableKind::kSE3:
      return "SE3";
    case VariableKind::kManifold:
      return type.manifold->name;
    case VariableKind::kVector:
      break;
  }
  return "vector of " + std::to_string(type.dim);
}

void retract(VariableType type, const double* x, const double* delta, double* out) {
  switch (type.kind) {
    case VariableKind::kSO2:
      return retract_group<SO2>(x, delta, out);
    case VariableKind::kSE2:
      return retract_group<SE2>(x, delta, out);
    case VariableKind::kSO3:
      return retract_group<SO3>(x, delta, out);
    case VariableKind::kSE3:
      return retract_group<SE3>(x, delta, out);
    case VariableKind::kManifold:
      return type.manifold->retract(x, delta, out);
    case VariableKind::kVector:
      for (int i = 0; i < type.dim; ++i) out[i] = x[i] + delta[i];
  }
}

void normalize(VariableType type, double* x) {
  switch (type.kind) {
    case VariableKind::kSO2:
      return normalize_group<SO2>(x);
    case VariableKind::kSE2:
      return normalize_group<SE2>(x);
    case VariableKind::kSO3:
      return normalize_group<SO3>(x);
    case VariableKind::kSE3:
      return normalize_group<SE3>(x);
    case VariableKind::kManifold:
      return type.manifold->normalize(x);
    case VariableKind::kVector:
      return;
  }
}

void local(VariableType type, const double* x, const double* y, double* delta) {
  switch (type.kind) {
    case VariableKind::kSO2:
      return local_group<SO2>(x, y, delta);
    case VariableKind::kSE2:
      return local_group<SE2>(x, y, delta);
    case VariableKind::kSO3:
      return local_group<SO3>(x, y, delta);
    case VariableKind::kSE3:
      return local_group<SE3>(x, y, delta);
    case VariableKind::kManifold:
      return type.manifold->local(x, y, delta);
    case VariableKind::kVector:
      for (int i = 0; i < type.dim; ++i) delta[i] = y[i] - x[i];
  }
}

Eigen::MatrixXd local_jacobian(VariableType type, const double* x, const double* y) {
  Eigen::VectorXd e(type.dim);
  local(type, x, y, e.data());
  switch (type.kind) {
    case VariableKind::kSE2:
      return SE2::right_jacobian_inverse(SE2::Tangent(e));
    case VariableKind::kSO3:
      return SO3::right_jacobian_inverse(SO3::Tangent(e));
    case VariableKind::kSE3:
      return SE3::right_jacobian_inverse(SE3::Tangent(e));
    case VariableKind::kManifold:
      return central_differences(type, y, type.dim, [&](const double* moved, double* delta) {
        local(type, x, moved, delta);
      });
    case VariableKind::kVector:
    case VariableKind::kSO2:
      break;
  }
  return Eigen::MatrixXd::Identity(type.dim, type.dim);
}

void retract_jacobian(VariableType type, const double* x, double* jacobian) {
  Eigen::Map<Eigen::MatrixXd> J(jacobian, type.size, type.dim);
  J.setZero();
  switch (type.kind) {
    case VariableKind::kSO2:
      J = turned(x);
      return;
    case VariableKind::kSE2:
      J.block<2, 2>(0, 0) = SO2::load(x + 2).matrix();
      J.block<2, 1>(2, 2) = turned(x + 2);
      return;
    case VariableKind::kSO3:
      J = turned_quaternion(x);
      return;
    case VariableKind::kSE3:
      J.block<3, 3>(0, 0) = SO3::load(x + 3).matrix();
      J.block<4, 3>(3, 3) = turned_quaternion(x + 3);
      return;
    case VariableKind::kManifold:
      J = central_differences(type, x, type.size, [&](const double* moved, double* storage) {
        std::copy_n(moved, type.size, storage);
      });
      return;
    case VariableKind::kVector:
      J.setIdentity();
  }
}

}  // namespace hybrid
