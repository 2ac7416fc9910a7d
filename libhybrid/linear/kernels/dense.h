// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>

#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {

/// The kernels for registers of kLanes doubles. The files that instantiate this are compiled for
/// different processors, and a function that they share would be linked once, for one of them. So
/// all code is in this template, and none of the standard library is called.
template <int kLanes>
struct DenseKernels {
  /// One register.
  using Pack [[gnu::vector_size(8 * kLanes)]] = double;
  /// Four rows, in as many registers as that takes.
  using Packet [[gnu::vector_size(8 * kPacket)]] = double;
  /// Either of them at any address. (An alignment of the vector itself is lost in a template.)
  template <class Vector>
  struct [[gnu::packed, gnu::may_alias]] Loose {
    Vector v;
  };

  static constexpr int kFrontRows = 2 * kLanes;  // of a tile
  static constexpr int kTileColumns = 4;

  static constexpr Kernels table(const char* name) {
    return {name,           kFrontRows,   dot,     eliminate, factorize_panel,
            update_columns, invert_panel, forward, backward};
  }

  static constexpr int least(int a, int b) { return a < b ? a : b; }
  static int rounded(int n) { return (n + kPacket - 1) / kPacket * kPacket; }
  template <class Vector = Packet>
  static Loose<Vector>& at(double* p) {
    return *reinterpret_cast<Loose<Vector>*>(p);
  }
  template <class Vector = Packet>
  static const Loose<Vector>& at(const double* p) {
    return *reinterpret_cast<const Loose<Vector>*>(p);
  }

  template <int kValue>
  struct Size {
    static constexpr int value = kValue;
  };

  /// Calls function(Size<n>) with n = min(4, columns), one of 1 .. 4.
  template <class Function>
  static void with_tile(int columns, const Function& function) {
    switch (columns) {
      case 1:
        return function(Size<1>());
      case 2:
        return function(Size<2>());
      case 3:
        return function(Size<3>());
      default:
        return function(Size<4>());
    }
  }

  static double dot(const double* a, const double* b, int n) {
    constexpr int kSums = 8;
    Pack sum[kSums / kLanes] = {};
    int i = 0;
    for (; i + kSums <= n; i += kSums) {
      for (int p = 0; p < kSums / kLanes; ++p) {
        sum[p] += at<Pack>(a + i + p * kLanes).v * at<Pack>(b + i + p * kLanes).v;
      }
    }
    double total = 0.0;
    for (int k = 0; k < kSums; ++k) total += sum[k / kLanes][k % kLanes];
    for (; i < n; ++i) total += a[i] * b[i];
    return total;
  }

  // Fronts.

  /// C -= A B' on one tile of kFrontRows x kTileColumns: A has kFrontRows rows and B kTileColumns
  /// rows of `depth` columns, all of the same stride.
  static void update_tile(double* c, const double* a, const double* b, int depth, int stride) {
    Pack acc[kTileColumns][2] = {};
    for (int k = 0; k < depth; ++k) {
      const Pack a0 = at<Pack>(a).v, a1 = at<Pack>(a + kLanes).v;
      for (int j = 0; j < kTileColumns; ++j) {
        const Pack bj = b[j] - Pack{};
        acc[j][0] += a0 * bj;
        acc[j][1] += a1 * bj;
      }
      a += stride;
      b += stride;
    }
    for (int j = 0; j < kTileColumns; ++j) {
      double* target = c + std::ptrdiff_t(j) * stride;
      at<Pack>(target).v -= acc[j][0];
      at<Pack>(target + kLanes).v -= acc[j][1];
    }
  }

  /// Whether the pivot of column j is acceptable; a pivot that is too small may be lifted.
  static bool accept(int j, double& pivot, Pivots& pivots) {
    if (pivots.lifted == nullptr) return pivot > pivots.least[j];
    if (pivot < pivots.least[j]) {
      pivot = pivots.least[j];
      pivots.lifted[pivots.lifted_count++] = j;
    }
    return __builtin_isfinite(pivot);
  }

  static int eliminate(double* front, int n, int stride, int f, Pivots& pivots) {
    const auto column = [&](int j) { return front + std::ptrdiff_t(j) * stride; };
    // Columns of L, four at a time: bring them up to date, then eliminate within the four.
    for (int j = 0; j < f; j += kTileColumns) {
      const int width = least(kTileColumns, f - j);
      for (int i = j; j > 0 && i < n; i += kFrontRows) {
        if (width == kTileColumns) {
          update_tile(column(j) + i, front + i, front + j, j, stride);
          continue;
        }
        for (int c = j; c < j + width; ++c) {
          double* target = column(c) + i;
          for (int k = 0; k < j; ++k) {
            const double factor = column(k)[c];
            const double* source = column(k) + i;
            for (int r = 0; r < kFrontRows; ++r) target[r] -= factor * source[r];
          }
        }
      }
      for (int c = j; c < j + width; ++c) {
        double* pivot = column(c);
        if (!accept(c, pivot[c], pivots)) return c;
        const double inverse = 1.0 / __builtin_sqrt(pivot[c]);
        for (int i = c; i < n; ++i) pivot[i] *= inverse;
        for (int k = c + 1; k < j + width; ++k) {
          double* target = column(k);
          const double factor = pivot[k];
          for (int i = k; i < n; ++i) target[i] -= factor * pivot[i];
        }
      }
    }
    // The Schur complement. Columns past the order are padding.
    for (int j = f; j < n; j += kTileColumns) {
      for (int i = j; i < n; i += kFrontRows) {
        update_tile(column(j) + i, front + i, front + j, f, stride);
      }
    }
    return -1;
  }

  // Panels.

  /// sum[c][q] += a(rows of packet q, p) b(c, p) over p < depth; a_stride and b_stride are the
  /// distances from p to p + 1.
  template <int kPackets, int kColumns>
  [[gnu::always_inline]] static inline void accumulate(const double* a, int a_stride,
                                                       const double* b, int b_stride, int depth,
                                                       Packet (&sum)[kColumns][kPackets]) {
    for (int p = 0; p < depth; ++p, a += a_stride, b += b_stride) {
      Packet rows[kPackets];
      for (int q = 0; q < kPackets; ++q) rows[q] = at(a + q * kPacket).v;
      for (int c = 0; c < kColumns; ++c) {
        for (int q = 0; q < kPackets; ++q) sum[c][q] += rows[q] * b[c];
      }
    }
  }

  /// Rows `row` .. of columns `first` .. of a panel: subtracts what the columns before contribute,
  /// then solves with the factorised diagonal tile, of which `inverse` holds the inverse diagonal.
  template <int kPackets, int kColumns>
  static void solve_tile(double* panel, int stride, int first, int row, const double* inverse) {
    Packet sum[kColumns][kPackets] = {};
    accumulate<kPackets, kColumns>(panel + row, stride, panel + first, stride, first, sum);
    for (int c = 0; c < kColumns; ++c) {
      double* column = panel + std::ptrdiff_t(first + c) * stride;
      for (int q = 0; q < kPackets; ++q) {
        double* target = column + row + q * kPacket;
        Packet x = at(target).v - sum[c][q];
        for (int d = 0; d < c; ++d) {
          x -= sum[d][q] * panel[std::ptrdiff_t(first + d) * stride + first + c];
        }
        sum[c][q] = x * inverse[c];  // from here on the solution
        at(target).v = sum[c][q];
      }
    }
  }

  /// Factorises columns first .. first + kColumns - 1 of a panel whose earlier columns are done.
  /// Returns the first column whose pivot is not positive, or -1.
  template <int kColumns>
  static int factorize_columns(double* panel, int stride, int height, int first) {
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
        if (!(x > 0.0) || !__builtin_isfinite(x)) {
          if (failed < 0) failed = first + c;
          x = 1.0;
        }
        column[c] = __builtin_sqrt(x);
        inverse[c] = 1.0 / column[c];
      }
    }
    int row = first + kColumns;
    for (; row + 2 * kPacket <= height + kRowPadding; row += 2 * kPacket) {
      solve_tile<2, kColumns>(panel, stride, first, row, inverse);
    }
    for (; row < height; row += kPacket)
      solve_tile<1, kColumns>(panel, stride, first, row, inverse);
    return failed;
  }

  static int factorize_panel(double* panel, int stride, int height, int columns) {
    int failed = -1;
    for (int first = 0; first < columns; first += kTileColumns) {
      int result = -1;
      with_tile(columns - first,
                [&](auto n) { result = factorize_columns<n.value>(panel, stride, height, first); });
      if (failed < 0) failed = result;
    }
    return failed;
  }

  /// One tile of out = -A B'.
  template <int kPackets>
  static void product_tile(const double* a, int a_stride, const double* b, int b_stride, int depth,
                           double* out, int out_stride) {
    Packet sum[kTileColumns][kPackets] = {};
    accumulate<kPackets, kTileColumns>(a, a_stride, b, b_stride, depth, sum);
    for (int c = 0; c < kTileColumns; ++c) {
      for (int q = 0; q < kPackets; ++q) {
        at(out + std::ptrdiff_t(c) * out_stride + q * kPacket).v = -1.0 * sum[c][q];
      }
    }
  }

  /// A column of tiles: rows begin .. end - 1 of A against four rows of B.
  static void product_column(const double* a, int a_stride, const double* b, int b_stride,
                             int depth, double* out, int out_stride, int begin, int end) {
    int row = begin;
    for (; row + 3 * kPacket <= end; row += 3 * kPacket) {
      product_tile<3>(a + row, a_stride, b, b_stride, depth, out + row, out_stride);
    }
    for (; row + 2 * kPacket <= end; row += 2 * kPacket) {
      product_tile<2>(a + row, a_stride, b, b_stride, depth, out + row, out_stride);
    }
    for (; row < end; row += kPacket) {
      product_tile<1>(a + row, a_stride, b, b_stride, depth, out + row, out_stride);
    }
  }

  static void update_columns(const double* panel, int stride, int columns, double* update, int size,
                             int begin, int end) {
    const double* below = panel + columns;
    for (int col = begin; col < end; col += kTileColumns) {
      product_column(below, stride, below + col, stride, columns,
                     update + std::ptrdiff_t(col) * size, size, col, size);
    }
  }

  /// out = -A B', rows and columns (multiples of four) of A and B.
  static void product(const double* a, int a_stride, const double* b, int b_stride, int depth,
                      double* out, int out_stride, int rows, int columns) {
    for (int col = 0; col < columns; col += kTileColumns) {
      product_column(a, a_stride, b + col, b_stride, depth, out + std::ptrdiff_t(col) * out_stride,
                     out_stride, 0, rows);
    }
  }

  /// sum over i of a[i] b[i], for short arrays.
  static double short_dot(const double* a, const double* b, int n) {
    Packet sum = {};
    int i = 0;
    for (; i + kPacket <= n; i += kPacket) sum += at(a + i).v * at(b + i).v;
    double total = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    for (; i < n; ++i) total += a[i] * b[i];
    return total;
  }

  /// y += factor * x.
  static void add_scaled(double factor, const double* x, double* y, int n) {
    int i = 0;
    for (; i + kPacket <= n; i += kPacket) at(y + i).v += factor * at(x + i).v;
    for (; i < n; ++i) y[i] += factor * x[i];
  }

  static void invert_panel(const PanelInverse& p) {
    const int k = p.columns;
    const int m = p.below;
    const int wide = rounded(k);
    const int tall = rounded(m);
    const auto column = [&](int col) { return p.panel + std::ptrdiff_t(col) * p.stride; };
    // L11^-1, column by column; lower triangular.
    for (int j = 0; j < k; ++j) {
      double* inverse = p.inverse + std::ptrdiff_t(j) * wide;
      inverse[j] = 1.0;
      for (int i = j; i < k; ++i) {
        inverse[i] /= column(i)[i];
        add_scaled(-inverse[i], column(i) + i + 1, inverse + i + 1, k - i - 1);
      }
    }
    // B' (k x m) = L11^-T L21': entry (c, r) sums the inverse's column c against row r.
    for (int r = 0; r < m; ++r) {
      for (int c = 0; c < k; ++c) {
        double sum = 0.0;
        for (int d = c; d < k; ++d) {
          sum += p.inverse[std::ptrdiff_t(c) * wide + d] * column(d)[k + r];
        }
        p.gain[std::ptrdiff_t(r) * wide + c] = sum;
      }
    }
    product(p.gain, wide, p.below_inverse, tall, m, p.coupling, wide, wide, tall);
    product(p.gain, wide, p.coupling, wide, m, p.own, wide, wide, wide);
    for (int c = 0; c < k; ++c) {
      double* out = p.out + std::ptrdiff_t(c) * p.stride;
      for (int r = c; r < k; ++r) {
        out[r] = p.own[std::ptrdiff_t(c) * wide + r] +
                 short_dot(p.inverse + std::ptrdiff_t(c) * wide + r,
                           p.inverse + std::ptrdiff_t(r) * wide + r, k - r);
      }
      for (int r = 0; r < m; ++r) out[k + r] = p.coupling[std::ptrdiff_t(r) * wide + c];
    }
  }

  // Substitution.

  template <int kColumns>
  static void forward_columns(const double* panel, int stride, int height, int first,
                              const double* inverse_diagonal, double* x) {
    const double* tile = panel + std::ptrdiff_t(first) * stride;
    double own[kColumns];
    for (int c = 0; c < kColumns; ++c) {
      double sum = x[first + c];
      for (int d = 0; d < c; ++d) sum -= tile[std::ptrdiff_t(d) * stride + first + c] * own[d];
      x[first + c] = own[c] = sum * inverse_diagonal[first + c];
    }
    for (int row = first + kColumns; row < height; row += kPacket) {
      Packet sum = at(x + row).v;
      for (int c = 0; c < kColumns; ++c) {
        sum -= own[c] * at(tile + std::ptrdiff_t(c) * stride + row).v;
      }
      at(x + row).v = sum;
    }
  }

  static void forward(const double* panel, int stride, int height, int columns,
                      const double* inverse_diagonal, double* x) {
    for (int first = 0; first < columns; first += kTileColumns) {
      with_tile(columns - first, [&](auto n) {
        forward_columns<n.value>(panel, stride, height, first, inverse_diagonal, x);
      });
    }
  }

  template <int kColumns>
  static void backward_columns(const double* panel, int stride, int height, int first,
                               const double* inverse_diagonal, double* x) {
    const double* tile = panel + std::ptrdiff_t(first) * stride;
    Packet sums[kColumns] = {};
    for (int row = first + kColumns; row < height; row += kPacket) {
      const Packet values = at(x + row).v;
      for (int c = 0; c < kColumns; ++c) {
        sums[c] += values * at(tile + std::ptrdiff_t(c) * stride + row).v;
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

  static void backward(const double* panel, int stride, int height, int columns,
                       const double* inverse_diagonal, double* x) {
    const int last = (columns - 1) / kTileColumns * kTileColumns;
    for (int first = last; first >= 0; first -= kTileColumns) {
      with_tile(columns - first, [&](auto n) {
        backward_columns<n.value>(panel, stride, height, first, inverse_diagonal, x);
      });
    }
  }
};

}  // namespace hybrid
