// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cstddef>

namespace hybrid {

/// Forward substitution with a panel of a Cholesky factor L (`height` x `columns`, column-major
/// with `stride` between columns, the diagonal block on top) for one right-hand side w of `height`
/// entries: solves for the first `columns` of them and subtracts their contributions from the
/// others. Four columns at a time, which for few right-hand sides is faster than a matrix product.
inline void substitute(const double* L, int stride, int height, int columns, double* w) {
  constexpr int kWidth = 4;
  for (int k = 0; k < columns; k += kWidth) {
    const int width = std::min(kWidth, columns - k);
    const double* column[kWidth];
    double x[kWidth];
    for (int i = 0; i < width; ++i) {
      column[i] = L + static_cast<std::ptrdiff_t>(k + i) * stride;
      double sum = w[k + i];
      for (int j = 0; j < i; ++j) sum -= column[j][k + i] * x[j];
      x[i] = w[k + i] = sum / column[i][k + i];
    }
    if (width == kWidth) {
      const double *a = column[0], *b = column[1], *c = column[2], *d = column[3];
      for (int r = k + kWidth; r < height; ++r) {
        w[r] -= a[r] * x[0] + b[r] * x[1] + c[r] * x[2] + d[r] * x[3];
      }
      continue;
    }
    for (int i = 0; i < width; ++i) {
      for (int r = k + width; r < height; ++r) w[r] -= column[i][r] * x[i];
    }
  }
}

/// The same for three right-hand sides, one after the other in memory, which read L together.
inline void substitute3(const double* L, int stride, int height, int columns, double* w) {
  constexpr int kWidth = 4;
  double* __restrict p = w;
  double* __restrict q = w + height;
  double* __restrict s = q + height;
  int k = 0;
  for (; k + kWidth <= columns; k += kWidth) {
    const double* a = L + static_cast<std::ptrdiff_t>(k) * stride;
    const double *b = a + stride, *c = b + stride, *d = c + stride;
    const auto solve = [&](double* x) {
      x[k] /= a[k];
      x[k + 1] = (x[k + 1] - a[k + 1] * x[k]) / b[k + 1];
      x[k + 2] = (x[k + 2] - a[k + 2] * x[k] - b[k + 2] * x[k + 1]) / c[k + 2];
      x[k + 3] =
          (x[k + 3] - a[k + 3] * x[k] - b[k + 3] * x[k + 1] - c[k + 3] * x[k + 2]) / d[k + 3];
    };
    solve(p);
    solve(q);
    solve(s);
    const double p0 = p[k], p1 = p[k + 1], p2 = p[k + 2], p3 = p[k + 3];
    const double q0 = q[k], q1 = q[k + 1], q2 = q[k + 2], q3 = q[k + 3];
    const double s0 = s[k], s1 = s[k + 1], s2 = s[k + 2], s3 = s[k + 3];
    for (int r = k + kWidth; r < height; ++r) {
      p[r] -= a[r] * p0 + b[r] * p1 + c[r] * p2 + d[r] * p3;
      q[r] -= a[r] * q0 + b[r] * q1 + c[r] * q2 + d[r] * q3;
      s[r] -= a[r] * s0 + b[r] * s1 + c[r] * s2 + d[r] * s3;
    }
  }
  for (; k < columns; ++k) {
    const double* a = L + static_cast<std::ptrdiff_t>(k) * stride;
    const double p0 = p[k] /= a[k], q0 = q[k] /= a[k], s0 = s[k] /= a[k];
    for (int r = k + 1; r < height; ++r) {
      p[r] -= a[r] * p0;
      q[r] -= a[r] * q0;
      s[r] -= a[r] * s0;
    }
  }
}

/// The same for `count` right-hand sides, one after the other in memory. One that is zero where it
/// would be solved for stays as it is: on the way up a tree, its variables are not below.
inline void substitute_all(const double* L, int stride, int height, int columns, double* w,
                           int count) {
  for (int k = 0; k < count;) {
    double* x = w + static_cast<std::ptrdiff_t>(k) * height;
    if (std::all_of(x, x + columns, [](double number) { return number == 0.0; })) {
      ++k;
    } else if (k + 3 <= count) {
      substitute3(L, stride, height, columns, x);
      k += 3;
    } else {
      substitute(L, stride, height, columns, x);
      ++k;
    }
  }
}

}  // namespace hybrid
