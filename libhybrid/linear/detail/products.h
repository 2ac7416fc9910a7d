// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/geometry/eigen.h"

namespace hybrid {

/// out += A' B for small column-major A (rows x m) and B (rows x n) at compile-time sizes.
template <int kRows, int kM, int kN>
void add_product(const double* a, const double* b, double* out, int stride) {
  Eigen::Map<Eigen::Matrix<double, kM, kN>, 0, Eigen::OuterStride<>> target(
      out, Eigen::OuterStride<>(stride));
  target.noalias() += Eigen::Map<const Eigen::Matrix<double, kRows, kM>>(a).transpose().lazyProduct(
      Eigen::Map<const Eigen::Matrix<double, kRows, kN>>(b));
}

/// out += A' B, out m x n with its columns `stride` apart. Sizes of poses and points in the plane
/// and in space are unrolled.
inline void add_product(const double* a, const double* b, int rows, int m, int n, double* out,
                        int stride) {
  switch (rows * 64 + m * 8 + n) {
    case 3 * 64 + 3 * 8 + 3:
      return add_product<3, 3, 3>(a, b, out, stride);
    case 6 * 64 + 6 * 8 + 6:
      return add_product<6, 6, 6>(a, b, out, stride);
    case 2 * 64 + 3 * 8 + 3:
      return add_product<2, 3, 3>(a, b, out, stride);
    case 2 * 64 + 2 * 8 + 2:
      return add_product<2, 2, 2>(a, b, out, stride);
    case 2 * 64 + 2 * 8 + 3:
      return add_product<2, 2, 3>(a, b, out, stride);
    case 2 * 64 + 3 * 8 + 2:
      return add_product<2, 3, 2>(a, b, out, stride);
    case 3 * 64 + 6 * 8 + 6:
      return add_product<3, 6, 6>(a, b, out, stride);
    case 3 * 64 + 3 * 8 + 6:
      return add_product<3, 3, 6>(a, b, out, stride);
    case 3 * 64 + 6 * 8 + 3:
      return add_product<3, 6, 3>(a, b, out, stride);
    case 2 * 64 + 6 * 8 + 6:
      return add_product<2, 6, 6>(a, b, out, stride);
    case 2 * 64 + 3 * 8 + 6:
      return add_product<2, 3, 6>(a, b, out, stride);
    case 2 * 64 + 6 * 8 + 3:
      return add_product<2, 6, 3>(a, b, out, stride);
    default:
      break;
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < m; ++i) {
      double sum = 0.0;
      for (int k = 0; k < rows; ++k) sum += a[i * rows + k] * b[j * rows + k];
      out[j * stride + i] += sum;
    }
  }
}

}  // namespace hybrid
