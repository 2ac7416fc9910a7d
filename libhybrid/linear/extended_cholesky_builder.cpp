// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "libhybrid/core/rank_update.h"
#include "libhybrid/linear/extended_cholesky.h"

namespace hybrid {
namespace {

/// With all pivots above this no eigenvalue of a block of a few dimensions is doubtful.
constexpr long double kClearPivot = 1e-3L;
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

/// Computes the factorisation.
class ExtendedCholesky::Builder {
 public:
  Builder(ExtendedCholesky& result, const ResidualLayout& layout, const double* J)
      : out_(result), fronts_(result.fronts_), dims_(result.dims_), layout_(layout), J_(J) {}

  void run() {
    number_blocks();
    build_fronts();
    place_residuals();
    for (Front& front : fronts_) factorize(front);
    for (std::size_t b = 0; b < moves_.size(); ++b) collect_directions(static_cast<int>(b));
  }

 private:
  void number_blocks();
  void build_fronts();
  void place_residuals();
  void factorize(Front& front);
  void add_residual(int residual, int alone, Matrix& F) const;
  void add_update(const Front& child, Matrix& F) const;
  void eliminate_block(Front& front, int k, Matrix& F);
  Matrix root_by_eigenvalues(Front& front, int k, const Matrix& A);
  Matrix slow_motion(const Front& front, int k, const Matrix& directions, Matrix& squared);
  void solve_lower(const Front& front, int columns, Matrix& x) const;
  void solve_upper(const Front& front, int columns, bool homogeneous, Matrix& x) const;
  Matrix gradient(const Front& front, const Matrix& v, Matrix& squared) const;
  void add_null_vector(const Front& front, const Matrix& v);
  void collect_directions(int block);

  /// Calls visit(block, its part of the Jacobian, not scaled) for the blocks of a residual.
  template <class Visit>
  void visit_blocks(const std::pair<int, int>& residual, const Visit& visit) const {
    const auto& r = layout_.residuals[residual.first];
    const double* entry = J_ + r.jacobian;
    for (int i = 0; i < r.count; ++i) {
      const int b = layout_.blocks[r.first + i];
      if (residual.second < 0 || residual.second == i) {
        visit(b, Eigen::Map<const Eigen::MatrixXd>(entry, r.rows, dims_[b]).cast<Real>());
      }
      entry += r.rows * dims_[b];
    }
  }
  /// The rows of a block in a vector over a subtree, which concatenates the own blocks of its
  /// fronts.
  auto rows(Matrix& x, int block) const {
    return x.middleRows(out_.starts_[block] - base_, dims_[block]);
  }
  auto rows(const Matrix& x, int block) const {
    return x.middleRows(out_.starts_[block] - base_, dims_[block]);
  }
  bool is_in(const Front& front, int block) const {
    return out_.front_of_[block] <= &front - fronts_.data();
  }
  /// Calls visit(front, number of columns) for all fronts below `front`, then with k for `front`.
  template <class Visit>
  void visit_up(const Front& front, int k, const Visit& visit) const {
    const int last = static_cast<int>(&front - fronts_.data());
    for (int f = front.first; f < last; ++f) {
      visit(fronts_[f], static_cast<int>(fronts_[f].columns.size()));
    }
    visit(front, k);
  }

  ExtendedCholesky& out_;
  std::vector<Front>& fronts_;
  const std::vector<int>& dims_;
  const ResidualLayout& layout_;
  const double* J_;
  std::vector<int> place_;     // by block: its first scalar in the current front
  int base_ = 0;               // first scalar of the current subtree
  std::vector<Matrix> moves_;  // by block: sum of u u' for its unit motions u by null vectors
};

void ExtendedCholesky::Builder::number_blocks() {
  for (int dim : dims_) out_.free_.emplace_back(dim, 0);
  out_.starts_.resize(dims_.size());
  out_.motion_.assign(dims_.size(), 0.0);
  out_.front_of_.resize(dims_.size());
  place_.resize(dims_.size());
  moves_.resize(dims_.size());
  out_.scale_.assign(dims_.size(), 0.0L);
  std::vector<Real> squares(dims_.size(), 0.0L);
  for (int r = 0; r < static_cast<int>(layout_.residuals.size()); ++r) {
    visit_blocks({r, -1}, [&](int b, const auto& J) { squares[b] += J.squaredNorm(); });
  }
  for (std::size_t b = 0; b < dims_.size(); ++b) {
    if (squares[b] > 0.0L) out_.scale_[b] = 1.0L / std::sqrt(squares[b]);
  }
}

void ExtendedCholesky::Builder::build_fronts() {
  const BlockOrdering ordering = order_blocks(layout_.pattern(), Trees::kAnyHeight);
  const int count = std::max<int>(static_cast<int>(ordering.supernodes.size()) - 1, 0);
  fronts_.resize(count);
  int scalars = 0;
  for (int f = 0; f < count; ++f) {
    Front& front = fronts_[f];
    front.first = f;
    front.starts.push_back(0);
    for (int i = ordering.row_starts[f]; i < ordering.row_starts[f + 1]; ++i) {
      front.blocks.push_back(ordering.order[ordering.rows[i]]);
      front.starts.push_back(front.starts.back() + dims_[front.blocks.back()]);
    }
    front.columns.resize(ordering.supernodes[f + 1] - ordering.supernodes[f]);
    for (std::size_t k = 0; k < front.columns.size(); ++k) {
      out_.front_of_[front.blocks[k]] = f;
      out_.starts_[front.blocks[k]] = scalars + front.starts[k];
    }
    scalars += front.starts[front.columns.size()];
  }
  for (int f = 0; f < count; ++f) {
    Front& front = fronts_[f];
    if (front.columns.size() == front.blocks.size()) continue;
    front.parent = out_.front_of_[front.blocks[front.columns.size()]];
    Front& parent = fronts_[front.parent];
    parent.children.push_back(f);
    parent.first = std::min(parent.first, front.first);
  }
}

/// Each residual goes to the front where the first of its blocks is eliminated; one that is not
/// coupled goes to all, as a residual of each of its blocks alone.
void ExtendedCholesky::Builder::place_residuals() {
  for (int r = 0; r < static_cast<int>(layout_.residuals.size()); ++r) {
    const auto& residual = layout_.residuals[r];
    const int* blocks = layout_.blocks.data() + residual.first;
    int first = static_cast<int>(fronts_.size());
    for (int i = 0; i < residual.count; ++i) {
      const int f = out_.front_of_[blocks[i]];
      if (!residual.coupled) fronts_[f].residuals.emplace_back(r, i);
      first = std::min(first, f);
    }
    if (residual.coupled && residual.count > 0) fronts_[first].residuals.emplace_back(r, -1);
  }
}

void ExtendedCholesky::Builder::factorize(Front& front) {
  for (std::size_t k = 0; k < front.blocks.size(); ++k) place_[front.blocks[k]] = front.starts[k];
  const int height = front.starts.back(), own = front.starts[front.columns.size()];
  Matrix F = Matrix::Zero(height, height);  // its lower triangle
  for (int child : front.children) {
    add_update(fronts_[child], F);
    front.smallest = std::min(front.smallest, fronts_[child].smallest);
    fronts_[child].update = {};
  }
  for (const auto& [residual, alone] : front.residuals) add_residual(residual, alone, F);
  for (int k = 0; k < static_cast<int>(front.columns.size()); ++k) eliminate_block(front, k, F);
  front.update = F.bottomRightCorner(height - own, height - own);
}

void ExtendedCholesky::Builder::add_residual(int residual, int alone, Matrix& F) const {
  std::vector<std::pair<int, Matrix>> parts;
  visit_blocks({residual, alone},
               [&](int b, const auto& J) { parts.emplace_back(b, J * out_.scale_[b]); });
  for (const auto& [a, Ja] : parts) {
    for (const auto& [b, Jb] : parts) {
      if (place_[a] < place_[b]) continue;
      F.block(place_[a], place_[b], dims_[a], dims_[b]).noalias() += Ja.transpose() * Jb;
    }
  }
}

void ExtendedCholesky::Builder::add_update(const Front& child, Matrix& F) const {
  const std::size_t own = child.columns.size();
  const int behind = child.starts[own];
  for (std::size_t i = own; i < child.blocks.size(); ++i) {
    for (std::size_t j = own; j <= i; ++j) {
      const int a = child.blocks[i], b = child.blocks[j];
      const auto from = child.update.block(child.starts[i] - behind, child.starts[j] - behind,
                                           dims_[a], dims_[b]);
      if (place_[a] >= place_[b]) {
        F.block(place_[a], place_[b], dims_[a], dims_[b]) += from;
      } else {
        F.block(place_[b], place_[a], dims_[b], dims_[a]) += from.transpose();
      }
    }
  }
}

void ExtendedCholesky::Builder::eliminate_block(Front& front, int k, Matrix& F) {
  Column& column = front.columns[k];
  const int start = front.starts[k], dim = front.starts[k + 1] - start;
  const int behind = front.starts.back() - start - dim;
  const Matrix A = F.block(start, start, dim, dim).template selfadjointView<Eigen::Lower>();
  const Eigen::LLT<Matrix> llt(A);
  const Real root = llt.matrixLLT().diagonal().minCoeff();
  if (llt.info() == Eigen::Success && root * root > kClearPivot) {
    column.root = llt.matrixU().solve(Matrix::Identity(dim, dim));
    front.smallest = std::min(front.smallest, root * root);
  } else {
    column.root = root_by_eigenvalues(front, k, A);
  }
  if (behind == 0) return column.below.resize(0, dim);
  column.below.noalias() = F.block(start + dim, start, behind, dim) * column.root;
  rank_update(F.bottomRightCorner(behind, behind), column.below, -1.0L);
}

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
  if (x.cols() == 0) return;
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

ExtendedCholesky::ExtendedCholesky(const ResidualLayout& layout, const double* J)
    : dims_(layout.dims) {
  Builder(*this, layout, J).run();
}

}  // namespace hybrid
