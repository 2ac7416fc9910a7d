// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "libhybrid/core/worker_pool.h"
#include "libhybrid/linear/block_cholesky.h"
#include "libhybrid/linear/block_matrix.h"
#include "libhybrid/linear/schur.h"

namespace HYBRID_API hybrid {

/// The layout of the linearised residuals of a problem in one buffer r and one buffer J, and the
/// variable blocks that they involve.
struct ResidualLayout {
  struct Residual {
    int rows = 0;
    int first = 0;  ///< its blocks are blocks[first] .. blocks[first + count - 1]
    int count = 0;
    std::size_t residual = 0;  ///< offset in r
    std::size_t jacobian = 0;  ///< offset in J; column-major, rows x sum of dims
    /// False: it enters the gradient and the diagonal blocks, not the off-diagonal ones, so that it
    /// costs no fill-in.
    bool coupled = true;
  };

  std::vector<int> dims;  ///< by variable block
  std::vector<int> blocks;
  std::vector<Residual> residuals;
  std::size_t residual_size = 0;
  std::size_t jacobian_size = 0;

  /// Appends a residual; `touched` are its blocks.
  void add(int rows, const int* touched, int count, bool coupled);
  /// Keeps the first `count` residuals only.
  void truncate(std::size_t count);
  BlockPattern pattern() const;
};

/// The Gauss-Newton system H d = -g with H = J'J and g = J'r, assembled into a fixed sparsity and
/// factorised in place. Vectors are in elimination order; `start(block)` is the first scalar of a
/// block.
class NormalEquations {
 public:
  explicit NormalEquations(const ResidualLayout& layout,
                           Elimination elimination = Elimination::kAutomatic);

  /// Changes to another layout of the same variables. False, with nothing changed, if that needs a
  /// block that the sparsity lacks or leaves so many unused that a new analysis pays.
  bool rebind(const ResidualLayout& layout);

  /// H and g from the buffers of the layout. The result does not depend on the number of threads.
  void assemble(const double* r, const double* J, WorkerPool& pool);

  /// Factorises H + damping * diag(H). Returns -1, or the block whose pivot failed.
  int factorize(double damping, WorkerPool& pool);
  /// x = (H + damping * diag(H))^-1 x for the last factorisation.
  void solve(double* x) const { by_schur() ? schur_.solve(x) : cholesky_.solve(x); }
  /// The smallest ratio of a pivot to the scale of its block, over the last factorisation: near the
  /// rounding error if the system is singular.
  double smallest_pivot_ratio() const;
  /// log of the determinant of the matrix factorised last, from the diagonal of its factor.
  double log_determinant() const;
  /// Root of the pivot of a scalar: the pivot is its information given the scalars eliminated
  /// later.
  double pivot_root(int scalar) const {
    return by_schur() ? schur_.diagonal(scalar) : cholesky_.diagonal(scalar);
  }

  int scalars() const { return matrix_.scalars(); }
  int start(int block) const { return matrix_.start(position_[block]); }
  int dim(int block) const { return matrix_.dim(position_[block]); }
  int position(int block) const { return position_[block]; }
  const std::vector<double>& gradient() const { return gradient_; }
  /// Diagonal of H, damping excluded; zero for a scalar with a zero Jacobian.
  const std::vector<double>& diagonal() const { return diagonal_; }
  /// Trace of the diagonal block of H at a position: the squared Frobenius norm of the Jacobian of
  /// the block, which does not depend on the frame of its tangent.
  double scale(int position) const { return scale_[position]; }
  /// H, its lower triangle in elimination order.
  const BlockMatrix& matrix() const { return matrix_; }
  /// Position -> block.
  const std::vector<int>& order() const { return order_; }
  /// Whether leaves are eliminated by Schur complement; else `cholesky` is the factor of all. Code
  /// that reads the factor needs Elimination::kPlain.
  bool by_schur() const { return schur_.leaf_count() > 0; }
  const SchurCholesky& schur() const { return schur_; }
  /// Throws Error if leaves are eliminated by Schur complement.
  const BlockCholesky& cholesky() const;

 private:
  struct Diagonal {
    std::uint32_t jacobian, residual;
    std::int32_t rows;
  };
  struct Coupling {
    std::uint32_t row, col;  // Jacobian blocks of the row and of the column
    std::int32_t rows;
  };

  bool bind(const ResidualLayout& layout);
  void assemble_column(int col, const double* r, const double* J);
  int block_of(int scalar) const;

  std::vector<int> order_;     // by position
  std::vector<int> position_;  // by block
  BlockMatrix matrix_;
  BlockCholesky cholesky_;  // one of these two is in use
  SchurCholesky schur_;
  std::vector<std::uint32_t> diagonal_begin_, coupling_begin_;  // by position; by stored block
  std::vector<Diagonal> diagonals_;
  std::vector<Coupling> couplings_;
  std::vector<double> gradient_, diagonal_, damping_;
  std::vector<double> scale_;  // by position
};

}  // namespace hybrid
