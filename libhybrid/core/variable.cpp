// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/variable.h"

namespace hybrid {
namespace {

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

}  // namespace

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
    case VariableKind::kVector:
      for (int i = 0; i < type.dim; ++i) delta[i] = y[i] - x[i];
  }
}

}  // namespace hybrid
