// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/detail/variance_components.h"

#include <algorithm>
#include <cmath>

namespace hybrid {
namespace {

using System = Eigen::Matrix<double, kMostComponents, kMostComponents>;

constexpr double kClip = 9;             // variances, the most that a square counts as
constexpr double kMeanClipped = 0.995;  // of the square of a standard normal variable, clipped so
constexpr double kLeastVariance = 1e-18;
constexpr int kRounds = 40, kSweeps = 200;
constexpr double kConverged = 1e-6;

double variance_of(const VarianceRow& row, const Components& variances) {
  return std::max(kLeastVariance, row.fixed + row.shares.dot(variances));
}

double clipped(const VarianceRow& row, double variance) {
  return std::min(row.square, kClip * variance) / kMeanClipped;
}

/// min 1/2 x' A x - b' x over x >= 0, by coordinate descent from `x`.
Components nonnegative_solution(const System& A, const Components& b, Components x) {
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double moved = 0;
    for (int i = 0; i < kMostComponents; ++i) {
      if (!(A(i, i) > 0)) continue;
      const double to = std::max(0.0, x[i] + (b[i] - A.row(i).dot(x)) / A(i, i));
      moved = std::max(moved, std::abs(to - x[i]) * std::sqrt(A(i, i)));
      x[i] = to;
    }
    if (moved < kConverged) break;
  }
  return x;
}

}  // namespace

Components fit_variances(const std::vector<VarianceRow>& rows, const Components& start,
                         int without) {
  Components x = start;
  for (int round = 0; round < kRounds; ++round) {
    System A = System::Zero();
    Components b = Components::Zero();
    for (const VarianceRow& row : rows) {
      if (row.part == without || !(row.weight > 0)) continue;
      const double v = variance_of(row, x), w = row.weight / (2 * v * v);
      A += w * row.shares * row.shares.transpose();
      b += w * (clipped(row, v) - row.fixed) * row.shares;
    }
    const Components next = nonnegative_solution(A, b, x);
    const double change = ((next - x).array().square() * A.diagonal().array()).sum();
    x = next;
    if (!(change > kConverged)) break;
  }
  return x;
}

double log_likelihood(const std::vector<VarianceRow>& rows, const Components& variances) {
  double sum = 0;
  for (const VarianceRow& row : rows) {
    const double v = variance_of(row, variances);
    sum -= 0.5 * row.weight * (std::log(v) + clipped(row, v) / v);
  }
  return sum;
}

}  // namespace hybrid
