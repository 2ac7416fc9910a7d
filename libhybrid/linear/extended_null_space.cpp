// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "libhybrid/linear/detail/extended_cholesky_builder.h"

namespace hybrid {
namespace {

constexpr long double kEpsilon = std::numeric_limits<long double>::epsilon();
/// The Schur complement of a block has an error of about epsilon / x once blocks with eigenvalues
/// down to x are eliminated; an eigenvalue below this many times that may be rounding error.
constexpr long double kDoubtful = 1e4L;
/// Eigenvectors have an error of epsilon / (distance of their eigenvalues). With a doubtful one,
/// all below this are computed again together, so that null vectors have no part of the others.
constexpr long double kSmall = 1e-6L;
/// Each step of refinement gains as many digits as the factor has right, four or more; it ends once
/// the error of v is at most kMoves even in the least determined direction.
constexpr int kMostRefinements = 8;
/// Half of the digits: a null vector that moves a block by less than this share of the largest
/// motion of a block moves it by rounding only.
constexpr double kMoves = 1e-8;

}  // namespace

/// The root of the pseudo-inverse of A. Eigenvalues that may be rounding error are computed again
/// from the residuals, and those that are zero are left out.
ExtendedCholesky::Matrix ExtendedCholesky::Builder::root_by_eigenvalues(Front& front, int k,
                                                                        const Matrix& A) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(A);
  Matrix vectors = eigen.eigenvectors();
  Eigen::Matrix<Real, Eigen::Dynamic, 1> values = eigen.eigenvalues();  // ascending
  const int dim = static_cast<int>(values.size());
  const Real limit = kDoubtful * kEpsilon / std::max(front.smallest, kEpsilon);
  int doubtful = 0, free = 0;
  while (doubtful < dim && !(values[doubtful] > limit)) ++doubtful;
  if (doubtful > 0) {
    while (doubtful < dim && values[doubtful] < kSmall) ++doubtful;
    Matrix squared;
    const Matrix v = slow_motion(front, k, vectors.leftCols(doubtful), squared);
    const Eigen::SelfAdjointEigenSolver<Matrix> by_residuals(squared);
    vectors.leftCols(doubtful) = (vectors.leftCols(doubtful) * by_residuals.eigenvectors()).eval();
    values.head(doubtful) = by_residuals.eigenvalues();
    for (; free < doubtful && !(values[free] > kRank); ++free) {
      add_null_vector(front, v * by_residuals.eigenvectors().col(free));
    }
    out_.nullity_ += free;
  }
  const auto kept = values.tail(dim - free);
  if (kept.size() > 0) front.smallest = std::min(front.smallest, kept.minCoeff());
  return vectors.rightCols(dim - free) * kept.cwiseSqrt().cwiseInverse().asDiagonal();
}

/// The vectors v of least |J v| that move block k of a front in the given directions, with the
/// blocks before it moving along and those behind it held; `squared` receives (J v)'(J v).
ExtendedCholesky::Matrix ExtendedCholesky::Builder::slow_motion(const Front& front, int k,
                                                                const Matrix& directions,
                                                                Matrix& squared) {
  base_ = out_.starts_[fronts_[front.first].blocks[0]];
  const int own = front.starts[front.columns.size()];
  Matrix v = Matrix::Zero(out_.starts_[front.blocks[0]] + own - base_, directions.cols());
  rows(v, front.blocks[k]) = directions;
  solve_upper(front, k, true, v);
  for (int i = 0; i <= kMostRefinements; ++i) {
    Matrix step = gradient(front, v, squared);
    solve_lower(front, k, step);
    for (std::size_t c = k; c < front.columns.size(); ++c) rows(step, front.blocks[c]).setZero();
    const Matrix gain = step.colwise().squaredNorm();  // decrease of |J v|^2
    if (!(gain.maxCoeff() > kMoves * kMoves * front.smallest)) break;
    solve_upper(front, k, false, step);
    v -= step;
  }
  return v;
}

/// x = L^-1 x for the blocks before column `columns` of a front, with those behind held.
void ExtendedCholesky::Builder::solve_lower(const Front& front, int columns, Matrix& x) const {
  visit_up(front, columns, [&](const Front& f, int count) {
    for (int k = 0; k < count; ++k) {
      const Column& column = f.columns[k];
      auto own = rows(x, f.blocks[k]);
      const Matrix solved = column.root.transpose() * own;
      own.setZero();
      own.topRows(solved.rows()) = solved;
      int below = 0;
      for (std::size_t i = k + 1; i < f.blocks.size(); ++i) {
        if (!is_in(front, f.blocks[i])) break;  // held, as all behind it
        const int dim = dims_[f.blocks[i]];
        rows(x, f.blocks[i]).noalias() -= column.below.middleRows(below, dim) * solved;
        below += dim;
      }
    }
  });
}

/// x = L'^-1 x for the same blocks; if `homogeneous` with a zero right-hand side, so that x follows
/// from the blocks behind alone.
void ExtendedCholesky::Builder::solve_upper(const Front& front, int columns, bool homogeneous,
                                            Matrix& x) const {
  for (int f = static_cast<int>(&front - fronts_.data()); f >= front.first; --f) {
    const Front& at = fronts_[f];
    for (int k = &at == &front ? columns : static_cast<int>(at.columns.size()); k-- > 0;) {
      const Column& column = at.columns[k];
      auto own = rows(x, at.blocks[k]);
      const int rank = static_cast<int>(column.root.cols());
      Matrix y = homogeneous ? Matrix::Zero(rank, x.cols()) : Matrix(own.topRows(rank));
      int below = 0;
      for (std::size_t i = k + 1; i < at.blocks.size(); ++i) {
        if (!is_in(front, at.blocks[i])) break;
        const int dim = dims_[at.blocks[i]];
        y.noalias() -= column.below.middleRows(below, dim).transpose() * rows(x, at.blocks[i]);
        below += dim;
      }
      own = column.root * y;
    }
  }
}

/// J'J v; `squared` receives (J v)'(J v).
ExtendedCholesky::Matrix ExtendedCholesky::Builder::gradient(const Front& front, const Matrix& v,
                                                             Matrix& squared) const {
  Matrix g = Matrix::Zero(v.rows(), v.cols());
  squared = Matrix(Matrix::Zero(v.cols(), v.cols()));
  visit_up(front, 0, [&](const Front& f, int) {
    for (const auto& residual : f.residuals) {
      Matrix motion = Matrix::Zero(layout_.residuals[residual.first].rows, v.cols());
      visit_blocks(residual, [&](int b, const auto& J) {
        if (is_in(front, b)) motion += J.lazyProduct(rows(v, b)) * out_.scale_[b];
      });
      visit_blocks(residual, [&](int b, const auto& J) {
        if (is_in(front, b)) rows(g, b) += J.transpose().lazyProduct(motion) * out_.scale_[b];
      });
      squared += motion.transpose().lazyProduct(motion);
    }
  });
  return g;
}

void ExtendedCholesky::Builder::add_null_vector(const Front& front, const Matrix& v) {
  std::vector<std::pair<int, Real>> norms;
  Real square = 0.0L, largest = 0.0L;
  visit_up(front, static_cast<int>(front.columns.size()), [&](const Front& f, int columns) {
    for (int k = 0; k < columns; ++k) {
      norms.emplace_back(f.blocks[k], rows(v, f.blocks[k]).norm());
      square += norms.back().second * norms.back().second;
      largest = std::max(largest, norms.back().second);
    }
  });
  for (const auto& [b, norm] : norms) {
    if (!(norm > kMoves * largest)) continue;
    const Matrix u = rows(v, b) / norm;
    if (moves_[b].size() == 0) moves_[b] = Matrix::Zero(dims_[b], dims_[b]);
    moves_[b] += u * u.transpose();
    out_.motion_[b] += static_cast<double>(norm * norm / square);
  }
}

void ExtendedCholesky::Builder::collect_directions(int block) {
  if (moves_[block].size() == 0) return;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(moves_[block]);
  int determined = 0;
  while (eigen.eigenvalues()[determined] < kMoves * kMoves) ++determined;
  out_.free_[block] =
      eigen.eigenvectors().rightCols(dims_[block] - determined).template cast<double>();
}

}  // namespace hybrid
