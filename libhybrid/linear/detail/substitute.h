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

}  // namespace hybrid
