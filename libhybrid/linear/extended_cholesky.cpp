// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/extended_cholesky.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "libhybrid/core/rank_update.h"
#include "libhybrid/linear/detail/extended_cholesky_builder.h"

namespace hybrid {
namespace {

/// With all pivots above this no eigenvalue of a block of a few dimensions is doubtful.
constexpr long double kClearPivot = 1e-3L;

}  // namespace

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

ExtendedCholesky::ExtendedCholesky(const ResidualLayout& layout, const double* J)
    : dims_(layout.dims) {
  Builder(*this, layout, J).run();
}

/// The pivot A of a column, in units of its scale, is stored as the root of its inverse: A^-1 =
/// root root'.
double ExtendedCholesky::log_determinant() const {
  if (nullity_ > 0) return -std::numeric_limits<double>::infinity();
  Real sum = 0.0L;
  for (const Front& front : fronts_) {
    for (std::size_t k = 0; k < front.columns.size(); ++k) {
      const Matrix& root = front.columns[k].root;
      sum += root.colPivHouseholderQr().logAbsDeterminant();
      sum += Real(root.rows()) * std::log(scale_[front.blocks[k]]);
    }
  }
  return static_cast<double>(-2.0L * sum);
}

/// Sigma = E' (L L')^-1 E = Y'Y with Y = L^-1 E, over the paths of the blocks to their roots.
Eigen::MatrixXd ExtendedCholesky::covariance(const std::vector<int>& blocks) const {
  std::map<int, int> rows;  // front -> where its own scalars stand in Y
  int columns = 0;
  for (int b : blocks) {
    for (int f = front_of_[b]; f >= 0; f = fronts_[f].parent) rows.emplace(f, 0);
    columns += dims_[b];
  }
  int size = 0;
  for (auto& [f, row] : rows) {
    row = size;
    size += fronts_[f].starts[fronts_[f].columns.size()];
  }
  const auto row_of = [&](int b) {
    const Front& own = fronts_[front_of_[b]];
    return rows.at(front_of_[b]) + starts_[b] - starts_[own.blocks[0]];
  };
  Matrix y = Matrix::Zero(size, columns);
  int column = 0;
  for (int b : blocks) {
    y.block(row_of(b), column, dims_[b], dims_[b]).diagonal().setConstant(scale_[b]);
    column += dims_[b];
  }
  for (const auto& [f, row] : rows) {
    const Front& front = fronts_[f];
    for (std::size_t k = 0; k < front.columns.size(); ++k) {
      const Column& eliminated = front.columns[k];
      auto own = y.middleRows(row + front.starts[k], dims_[front.blocks[k]]);
      const Matrix solved = eliminated.root.transpose() * own;
      own.setZero();
      own.topRows(solved.rows()) = solved;
      int below = 0;
      for (std::size_t i = k + 1; i < front.blocks.size(); ++i) {
        const int dim = dims_[front.blocks[i]];
        y.middleRows(row_of(front.blocks[i]), dim).noalias() -=
            eliminated.below.middleRows(below, dim) * solved;
        below += dim;
      }
    }
  }
  return (y.transpose() * y).cast<double>();
}

}  // namespace hybrid
