// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>

/// Dense kernels of the Cholesky factorisation on column-major panels. Rows are worked in packets
/// of four, so panels have kRowPadding rows of padding at the end of each column and update
/// matrices a size rounded up to a multiple of four: what the kernels write there is never used.
namespace hybrid::front {

constexpr int kPacket = 4;
constexpr int kRowPadding = kPacket - 1;
constexpr int kTileColumns = 4;

using Packet [[gnu::vector_size(kPacket * sizeof(double)), gnu::aligned(8), gnu::may_alias]] =
    double;

inline int round_up(int n) {
  return (n + kPacket - 1) / kPacket * kPacket;
}

/// sum[c][q] += a(rows of packet q, p) b(c, p) over p < depth; a_stride and b_stride lead from p to
/// p + 1.
template <int kPackets, int kColumns>
[[gnu::always_inline]] inline void accumulate(const double* a, int a_stride, const double* b,
                                              int b_stride, int depth,
                                              Packet (&sum)[kColumns][kPackets]) {
  for (int p = 0; p < depth; ++p, a += a_stride, b += b_stride) {
    Packet rows[kPackets];
    for (int q = 0; q < kPackets; ++q) {
      rows[q] = *reinterpret_cast<const Packet*>(a + q * kPacket);
    }
    for (int c = 0; c < kColumns; ++c) {
      for (int q = 0; q < kPackets; ++q) sum[c][q] += rows[q] * b[c];
    }
  }
}

/// Rows `row` .. of columns `first` .. of a panel: subtracts what the columns before contribute,
/// then solves with the factorised diagonal tile, of which `inverse` holds the inverse diagonal.
template <int kPackets, int kColumns>
inline void solve_tile(double* panel, int stride, int first, int row, const double* inverse) {
  Packet sum[kColumns][kPackets] = {};
  accumulate<kPackets, kColumns>(panel + row, stride, panel + first, stride, first, sum);
  for (int c = 0; c < kColumns; ++c) {
    double* column = panel + std::ptrdiff_t(first + c) * stride;
    for (int q = 0; q < kPackets; ++q) {
      Packet& target = *reinterpret_cast<Packet*>(column + row + q * kPacket);
      Packet x = target - sum[c][q];
      for (int d = 0; d < c; ++d) {
        x -= sum[d][q] * panel[std::ptrdiff_t(first + d) * stride + first + c];
      }
      sum[c][q] = x * inverse[c];  // from here on the solution
      target = sum[c][q];
    }
  }
}

/// Factorises columns first .. first + kColumns - 1 of a panel whose earlier columns are done.
/// Returns the first column whose pivot is not positive, or -1.
template <int kColumns>
int factorize_columns(double* panel, int stride, int height, int first) {
  Packet sum[kColumns][1] = {};
  accumulate<1, kColumns>(panel + first, stride, panel + first, stride, first, sum);
  int failed = -1;
  double inverse[kColumns];
  for (int c = 0; c < kColumns; ++c) {
    double* column = panel + std::ptrdiff_t(first + c) * stride + first;
    for (int r = c; r < kColumns; ++r) {
      double x = column[r] - sum[c][0][r];
      for (int d = 0; d < c; ++d) {
        const double* before = panel + std::ptrdiff_t(first + d) * stride + first;
        x -= before[r] * before[c];
      }
      if (r > c) {
        column[r] = x * inverse[c];
        continue;
      }
      if (!(x > 0.0) || !std::isfinite(x)) {
        if (failed < 0) failed = first + c;
        x = 1.0;
      }
      column[c] = std::sqrt(x);
      inverse[c] = 1.0 / column[c];
    }
  }
  int row = first + kColumns;
  for (; row + 2 * kPacket <= height + kRowPadding; row += 2 * kPacket) {
    solve_tile<2, kColumns>(panel, stride, first, row, inverse);
  }
  for (; row < height; row += kPacket) solve_tile<1, kColumns>(panel, stride, first, row, inverse);
  return failed;
}

/// Calls function(integral constant n) with n = min(4, columns - first), one of 1 .. 4.
template <class Function>
inline void with_tile_columns(int columns, int first, const Function& function) {
  switch (std::min(kTileColumns, columns - first)) {
    case 1:
      return function(std::integral_constant<int, 1>());
    case 2:
      return function(std::integral_constant<int, 2>());
    case 3:
      return function(std::integral_constant<int, 3>());
    default:
      return function(std::integral_constant<int, 4>());
  }
}

/// Cholesky of the first `columns` columns of a panel of `height` rows. Returns as above.
inline int factorize_panel(double* panel, int stride, int height, int columns) {
  int failed = -1;
  for (int first = 0; first < columns; first += kTileColumns) {
    int result = -1;
    with_tile_columns(columns, first, [&](auto n) {
      result = factorize_columns<n()>(panel, stride, height, first);
    });
    if (failed < 0) failed = result;
  }
  return failed;
}

/// One tile of out = sign A B'.
template <int kPackets>
inline void product_tile(const double* a, int a_stride, const double* b, int b_stride, int depth,
                         double sign, double* out, int out_stride) {
  Packet sum[kTileColumns][kPackets] = {};
  accumulate<kPackets, kTileColumns>(a, a_stride, b, b_stride, depth, sum);
  for (int c = 0; c < kTileColumns; ++c) {
    for (int q = 0; q < kPackets; ++q) {
      *reinterpret_cast<Packet*>(out + std::ptrdiff_t(c) * out_stride + q * kPacket) =
          sign * sum[c][q];
    }
  }
}

/// A column of tiles: rows begin .. end - 1 of A against four rows of B.
inline void product_column(const double* a, int a_stride, const double* b, int b_stride, int depth,
                           double sign, double* out, int out_stride, int begin, int end) {
  int row = begin;
  for (; row + 3 * kPacket <= end; row += 3 * kPacket) {
    product_tile<3>(a + row, a_stride, b, b_stride, depth, sign, out + row, out_stride);
  }
  for (; row + 2 * kPacket <= end; row += 2 * kPacket) {
    product_tile<2>(a + row, a_stride, b, b_stride, depth, sign, out + row, out_stride);
  }
  for (; row < end; row += kPacket) {
    product_tile<1>(a + row, a_stride, b, b_stride, depth, sign, out + row, out_stride);
  }
}

/// The lower triangle of U = -B B' for columns begin .. end - 1 (multiples of four), where B are
/// the rows below the first `columns` of a panel and `size` is the rounded size of U.
inline void update_columns(const double* panel, int stride, int columns, double* update, int size,
                           int begin, int end) {
  const double* below = panel + columns;
  for (int col = begin; col < end; col += kTileColumns) {
    product_column(below, stride, below + col, stride, columns, -1.0,
                   update + std::ptrdiff_t(col) * size, size, col, size);
  }
}

/// out = sign A B', rows and columns (multiples of four) of A and B.
inline void product(const double* a, int a_stride, const double* b, int b_stride, int depth,
                    double sign, double* out, int out_stride, int rows, int columns) {
  for (int col = 0; col < columns; col += kTileColumns) {
    product_column(a, a_stride, b + col, b_stride, depth, sign,
                   out + std::ptrdiff_t(col) * out_stride, out_stride, 0, rows);
  }
}

/// sum over i of a[i] b[i].
inline double dot(const double* a, const double* b, int n) {
  Packet sum = {};
  int i = 0;
  for (; i + kPacket <= n; i += kPacket) {
    sum += *reinterpret_cast<const Packet*>(a + i) * *reinterpret_cast<const Packet*>(b + i);
  }
  double total = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  for (; i < n; ++i) total += a[i] * b[i];
  return total;
}

/// y += factor * x.
inline void add_scaled(double factor, const double* x, double* y, int n) {
  int i = 0;
  for (; i + kPacket <= n; i += kPacket) {
    *reinterpret_cast<Packet*>(y + i) += factor * *reinterpret_cast<const Packet*>(x + i);
  }
  for (; i < n; ++i) y[i] += factor * x[i];
}

/// Forward substitution with columns first .. first + kColumns - 1 of a panel on `x`, which has a
/// row for each row of the panel and three of padding.
template <int kColumns>
inline void forward_columns(const double* panel, int stride, int height, int first,
                            const double* inverse_diagonal, double* x) {
  const double* tile = panel + std::ptrdiff_t(first) * stride;
  double own[kColumns];
  for (int c = 0; c < kColumns; ++c) {
    double sum = x[first + c];
    for (int d = 0; d < c; ++d) sum -= tile[std::ptrdiff_t(d) * stride + first + c] * own[d];
    x[first + c] = own[c] = sum * inverse_diagonal[first + c];
  }
  for (int row = first + kColumns; row < height; row += kPacket) {
    Packet& target = *reinterpret_cast<Packet*>(x + row);
    Packet sum = target;
    for (int c = 0; c < kColumns; ++c) {
      sum -= own[c] * *reinterpret_cast<const Packet*>(tile + std::ptrdiff_t(c) * stride + row);
    }
    target = sum;
  }
}

/// Backward substitution with the transpose of the same columns; the padding of `x` must be zero.
template <int kColumns>
inline void backward_columns(const double* panel, int stride, int height, int first,
                             const double* inverse_diagonal, double* x) {
  const double* tile = panel + std::ptrdiff_t(first) * stride;
  Packet sums[kColumns] = {};
  for (int row = first + kColumns; row < height; row += kPacket) {
    const Packet values = *reinterpret_cast<const Packet*>(x + row);
    for (int c = 0; c < kColumns; ++c) {
      sums[c] += values * *reinterpret_cast<const Packet*>(tile + std::ptrdiff_t(c) * stride + row);
    }
  }
  for (int c = kColumns - 1; c >= 0; --c) {
    double sum = x[first + c] - ((sums[c][0] + sums[c][1]) + (sums[c][2] + sums[c][3]));
    for (int d = c + 1; d < kColumns; ++d) {
      sum -= tile[std::ptrdiff_t(c) * stride + first + d] * x[first + d];
    }
    x[first + c] = sum * inverse_diagonal[first + c];
  }
}

}  // namespace hybrid::front
