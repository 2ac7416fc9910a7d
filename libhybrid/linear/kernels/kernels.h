// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

namespace hybrid {

/// Least pivots of a front, by column, and the columns whose pivots were lifted.
struct Pivots {
  const double* least;
  /// Null: the elimination ends at a pivot that is not above least[j]. Otherwise room for one entry
  /// per column: a pivot below least[j] is lifted to it, and j is appended.
  int* lifted;
  int lifted_count;
};

/// Input, scratch and output of the inverse of a supernode, all column-major. With k columns, m
/// rows below, wide = round_up(k) and tall = round_up(m): `inverse` and `own` are wide x wide,
/// `gain` and `coupling` wide x (tall + 1); these four are scratch and must be zero.
struct PanelInverse {
  const double* panel;
  int stride, columns, below;
  /// The inverse of the rows below, tall x tall.
  const double* below_inverse;
  double *inverse, *own, *gain, *coupling;
  /// Receives k columns, `stride` apart, of the inverse.
  double* out;
};

/// Rows are processed in packets of four: panels have kRowPadding more rows, and update matrices a
/// size rounded up to a multiple of four. Entries of the padding are never used.
constexpr int kPacket = 4;
constexpr int kRowPadding = kPacket - 1;

inline int round_up(int n) {
  return (n + kPacket - 1) / kPacket * kPacket;
}

/// The dense kernels, compiled for one set of instructions. All sets give the same bits: every sum
/// is made in the same order whatever the width of the registers, and nothing is fused. Matrices
/// are column-major; `stride` is the distance between columns.
struct Kernels {
  /// Name of the set of instructions.
  const char* name;
  /// Number of padding rows of a front; it has four padding columns, too.
  int front_padding;

  /// sum over i of a[i] b[i].
  double (*dot)(const double* a, const double* b, int n);
  /// Partial Cholesky of the lower triangle of a front of order n: the first f columns become those
  /// of L, the rest the Schur complement. Returns -1, or the column at which it ended.
  int (*eliminate)(double* front, int n, int stride, int f, Pivots& pivots);
  /// Cholesky of the first `columns` columns of a panel of `height` rows. Returns the first column
  /// whose pivot is not positive, or -1.
  int (*factorize_panel)(double* panel, int stride, int height, int columns);
  /// Columns begin .. end - 1 (multiples of four) of the lower triangle of U = -B B', where B are
  /// the rows below the first `columns` of a panel and `size` is the rounded size of U.
  void (*update_columns)(const double* panel, int stride, int columns, double* update, int size,
                         int begin, int end);
  /// With the panel (L11; L21), B = L21 L11^-1 and the inverse Z22 of the rows below:
  /// Z21 = -Z22 B and Z11 = (L11 L11')^-1 - B' Z21.
  void (*invert_panel)(const PanelInverse& p);
  /// Forward substitution with a panel on x, which has an entry for each row and three of padding.
  void (*forward)(const double* panel, int stride, int height, int columns,
                  const double* inverse_diagonal, double* x);
  /// Backward substitution with its transpose; the padding of x must be zero.
  void (*backward)(const double* panel, int stride, int height, int columns,
                   const double* inverse_diagonal, double* x);
};

/// Each is in a file of its own, compiled for its instructions: it may be used only if the
/// processor has them.
extern const Kernels kBaselineKernels;
extern const Kernels kAvx2Kernels;
extern const Kernels kAvx512Kernels;

/// The kernels for the widest registers of this processor.
const Kernels& kernels();

/// All kernels that this processor can run, the narrowest first.
const std::vector<const Kernels*>& supported_kernels();

}  // namespace hybrid
