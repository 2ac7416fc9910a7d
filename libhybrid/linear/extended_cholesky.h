// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <utility>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/linear/normal_equations.h"

namespace HYBRID_API hybrid {

/// Cholesky factorisation of J'J in extended precision that finds the null space of J. It is the
/// one definition of "not determined": a variable is not determined by the residuals where it can
/// move with J v = 0, up to rounding.
///
/// The columns of each block are divided by the Frobenius norm of the block, which a rotation of
/// the map or of a tangent frame leaves as it is, and so are the eigenvalues that decide. A
/// variable that no residual moves has norm zero, and is free in all directions. Blocks are
/// eliminated in turn. A small eigenvalue of what is left of one is the square of the least |J v|
/// with which it can move by one, the blocks before it with it and those behind it held; where it
/// may be rounding error, v is computed, refined with J itself, and |J v|^2 decides against kRank.
///
/// Rounding of J (1e-16) makes |J v|^2 of a null vector about 1e-32 times the sum of squares of v:
/// 1e-22 in a map of 100 m with 10,000 loops that may turn as a whole. The end of a chain of n
/// poses that is held at its start has some n^-3: 1e-15 at 100,000. It costs some twenty to fifty
/// times a factorisation in double precision, which tells when to ask.
class ExtendedCholesky {
 public:
  static constexpr double kRank = 1e-18;

  /// `J` is the buffer of the layout and must be finite; neither is needed afterwards.
  ExtendedCholesky(const ResidualLayout& layout, const double* J);

  /// Dimension of the null space.
  int nullity() const { return nullity_; }
  /// Orthonormal basis (dim x k) of the directions in which null vectors move a block; k = 0 where
  /// it is determined.
  const Eigen::MatrixXd& free_directions(int block) const { return free_[block]; }
  /// How much null vectors move a block, all blocks and null vectors alike: 0 where it is
  /// determined.
  double motion(int block) const { return motion_[block]; }
  /// log det(J'J); minus infinity where it is singular.
  double log_determinant() const;
  /// Covariance (J'J)^-1 of some blocks, in the order given: of linear forms that no null vector
  /// moves. Other entries are what holding the null space at any one point would leave.
  Eigen::MatrixXd covariance(const std::vector<int>& blocks) const;

 private:
  using Real = long double;
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

  /// A block as eliminated: with A what was left of its diagonal block and B of its rows below,
  /// A^+ = root root' and below = B root.
  struct Column {
    Matrix root;   // dim x rank
    Matrix below;  // rows of the front behind the block x rank
  };
  /// Blocks that are eliminated together, and those that they meet later.
  struct Front {
    std::vector<int> blocks;  // own blocks first, ascending by position
    std::vector<int> starts;  // of their scalars in the front, and the end
    std::vector<Column> columns;
    /// Residuals whose first block is one of its own, and of which block alone, or -1.
    std::vector<std::pair<int, int>> residuals;
    int parent = -1;
    std::vector<int> children;
    int first = 0;         // its subtree is the fronts first .. itself
    Matrix update;         // to the parent, until taken
    Real smallest = 1.0L;  // eigenvalue that was kept in its subtree
  };
  class Builder;

  std::vector<int> dims_;      // by block
  std::vector<int> starts_;    // by block: its scalars in order of elimination
  std::vector<Real> scale_;    // by block: 1 / norm; 0 where no residual moves it
  std::vector<int> front_of_;  // by block
  std::vector<Front> fronts_;  // in order of elimination
  int nullity_ = 0;
  std::vector<Eigen::MatrixXd> free_;
  std::vector<double> motion_;
};

}  // namespace hybrid
