// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/front.h"

#include <algorithm>
#include <cmath>

#include "libhybrid/linear/dot.h"

namespace hybrid {
namespace {

// One register of doubles, as wide as the processor has them; the second type reads them from any
// address. Every sum is made in the same order whatever the width.
#ifdef HYBRID_FRONT_LANES
constexpr int kLanes = HYBRID_FRONT_LANES;
#else
constexpr int kLanes = 2;
#endif
typedef double Pack __attribute__((vector_size(8 * kLanes)));
typedef double LoosePack __attribute__((vector_size(8 * kLanes), aligned(8), may_alias));

constexpr int kRows = 2 * kLanes;  // of a tile
constexpr int kCols = 4;

/// C -= A B' on one tile of kRows x kCols: A has kRows rows and B kCols rows of `depth` columns,
/// all of the same stride.
inline void update_tile(double* c, const double* a, const double* b, int depth, int stride) {
  Pack acc[kCols][2] = {};
  for (int k = 0; k < depth; ++k) {
    const Pack a0 = *reinterpret_cast<const LoosePack*>(a);
    const Pack a1 = *reinterpret_cast<const LoosePack*>(a + kLanes);
    for (int j = 0; j < kCols; ++j) {
      const Pack bj = b[j] - Pack{};
      acc[j][0] += a0 * bj;
      acc[j][1] += a1 * bj;
    }
    a += stride;
    b += stride;
  }
  for (int j = 0; j < kCols; ++j) {
    LoosePack* c0 = reinterpret_cast<LoosePack*>(c + static_cast<std::size_t>(j) * stride);
    LoosePack* c1 = reinterpret_cast<LoosePack*>(c + static_cast<std::size_t>(j) * stride + kLanes);
    *c0 = *c0 - acc[j][0];
    *c1 = *c1 - acc[j][1];
  }
}

}  // namespace

double dot(const double* a, const double* b, int n) {
  constexpr int kSums = 8;
  Pack sum[kSums / kLanes] = {};
  int i = 0;
  for (; i + kSums <= n; i += kSums) {
    for (int p = 0; p < kSums / kLanes; ++p) {
      sum[p] += *reinterpret_cast<const LoosePack*>(a + i + p * kLanes) *
                *reinterpret_cast<const LoosePack*>(b + i + p * kLanes);
    }
  }
  double total = 0.0;
  for (int k = 0; k < kSums; ++k) total += sum[k / kLanes][k % kLanes];
  for (; i < n; ++i) total += a[i] * b[i];
  return total;
}

void Front::reset(int n) {
  n_ = n;
  stride_ = (n + kRows + 3) / 4 * 4;
  const std::size_t size = static_cast<std::size_t>(stride_) * (n + kCols);
  if (data_.size() < size) data_.resize(size + size / 2);
  for (int j = 0; j < n + kCols; ++j)
    std::fill(column(j) + std::min(j, n), column(j) + stride_, 0.0);
}

int Front::factorize(int f, double tolerance) {
  diagonal_.resize(f);
  for (int j = 0; j < f; ++j) diagonal_[j] = (*this)(j, j);
  return eliminate(f, [&](int j, double& pivot) { return pivot > tolerance * diagonal_[j]; });
}

int Front::factorize(int f, const double* least, std::vector<int>& lifted) {
  return eliminate(f, [&](int j, double& pivot) {
    if (pivot < least[j]) {
      pivot = least[j];
      lifted.push_back(j);
    }
    return std::isfinite(pivot);
  });
}

/// Eliminates the first f columns; accept(j, pivot) may change the pivot of column j, and ends the
/// elimination by returning false.
template <class Pivot>
int Front::eliminate(int f, const Pivot& accept) {
  // Columns of L, four at a time: bring them up to date, then eliminate within the four.
  for (int j = 0; j < f; j += kCols) {
    const int width = std::min(kCols, f - j);
    if (j > 0) {
      for (int i = j; i < n_; i += kRows) {
        if (width == kCols) {
          update_tile(column(j) + i, column(0) + i, column(0) + j, j, stride_);
          continue;
        }
        for (int c = j; c < j + width; ++c) {
          double* target = column(c) + i;
          for (int k = 0; k < j; ++k) {
            const double factor = column(k)[c];
            const double* source = column(k) + i;
            for (int r = 0; r < kRows; ++r) target[r] -= factor * source[r];
          }
        }
      }
    }
    for (int c = j; c < j + width; ++c) {
      double* pivot = column(c);
      if (!accept(c, pivot[c])) return c;
      const double inverse = 1.0 / std::sqrt(pivot[c]);
      for (int i = c; i < n_; ++i) pivot[i] *= inverse;
      for (int k = c + 1; k < j + width; ++k) {
        double* target = column(k);
        const double factor = pivot[k];
        for (int i = k; i < n_; ++i) target[i] -= factor * pivot[i];
      }
    }
  }
  // The Schur complement. Columns past the order are padding.
  for (int j = f; j < n_; j += kCols) {
    for (int i = j; i < n_; i += kRows) {
      update_tile(column(j) + i, column(0) + i, column(0) + j, f, stride_);
    }
  }
  return -1;
}

}  // namespace hybrid
