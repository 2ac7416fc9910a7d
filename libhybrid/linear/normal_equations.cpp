// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/normal_equations.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libhybrid/core/error.h"
#include "libhybrid/core/paced_task.h"
#include "libhybrid/core/sort_unique.h"
#include "libhybrid/geometry/eigen.h"

namespace hybrid {
namespace {

/// out += A' B for small column-major A (rows x m) and B (rows x n) at compile-time sizes.
template <int kRows, int kM, int kN>
void add_product(const double* a, const double* b, double* out, int stride) {
  Eigen::Map<Eigen::Matrix<double, kM, kN>, 0, Eigen::OuterStride<>> target(
      out, Eigen::OuterStride<>(stride));
  target.noalias() += Eigen::Map<const Eigen::Matrix<double, kRows, kM>>(a).transpose().lazyProduct(
      Eigen::Map<const Eigen::Matrix<double, kRows, kN>>(b));
}

/// out += A' B, out m x n with its columns `stride` apart. Sizes of poses and points in the plane
/// and in space are unrolled.
inline void add_product(const double* a, const double* b, int rows, int m, int n, double* out,
                        int stride) {
  switch (rows * 64 + m * 8 + n) {
    case 3 * 64 + 3 * 8 + 3:
      return add_product<3, 3, 3>(a, b, out, stride);
    case 6 * 64 + 6 * 8 + 6:
      return add_product<6, 6, 6>(a, b, out, stride);
    case 2 * 64 + 3 * 8 + 3:
      return add_product<2, 3, 3>(a, b, out, stride);
    case 2 * 64 + 2 * 8 + 2:
      return add_product<2, 2, 2>(a, b, out, stride);
    case 2 * 64 + 2 * 8 + 3:
      return add_product<2, 2, 3>(a, b, out, stride);
    case 2 * 64 + 3 * 8 + 2:
      return add_product<2, 3, 2>(a, b, out, stride);
    case 3 * 64 + 6 * 8 + 6:
      return add_product<3, 6, 6>(a, b, out, stride);
    case 3 * 64 + 3 * 8 + 6:
      return add_product<3, 3, 6>(a, b, out, stride);
    case 3 * 64 + 6 * 8 + 3:
      return add_product<3, 6, 3>(a, b, out, stride);
    case 2 * 64 + 6 * 8 + 6:
      return add_product<2, 6, 6>(a, b, out, stride);
    case 2 * 64 + 3 * 8 + 6:
      return add_product<2, 3, 6>(a, b, out, stride);
    case 2 * 64 + 6 * 8 + 3:
      return add_product<2, 6, 3>(a, b, out, stride);
    default:
      break;
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < m; ++i) {
      double sum = 0.0;
      for (int k = 0; k < rows; ++k) sum += a[i * rows + k] * b[j * rows + k];
      out[j * stride + i] += sum;
    }
  }
}

constexpr int kColumnsPerTask = 256;
/// Smaller matrices are assembled by one thread.
constexpr std::size_t kParallelEntries = 60000;
/// Damping is relative to the diagonal, which is kept above this share of its mean so that nearly
/// unobserved directions are damped too.
constexpr double kDiagonalFloor = 1e-9;
/// A new analysis pays when this share of the off-diagonal blocks went out of use.
constexpr double kUnusedShare = 0.02;
/// Multiplications for each block in the time that the analysis of its matrix takes, about.
constexpr double kWorkOfBlock = 1e3;

}  // namespace

void ResidualLayout::add(int rows, const int* touched, int count, bool coupled) {
  residuals.push_back(
      {rows, static_cast<int>(blocks.size()), count, residual_size, jacobian_size, coupled});
  blocks.insert(blocks.end(), touched, touched + count);
  residual_size += rows;
  for (int i = 0; i < count; ++i) jacobian_size += std::size_t(rows) * dims[touched[i]];
}

void ResidualLayout::truncate(std::size_t count) {
  if (count >= residuals.size()) return;
  const Residual& next = residuals[count];
  blocks.resize(next.first);
  residual_size = next.residual;
  jacobian_size = next.jacobian;
  residuals.resize(count);
}

BlockPattern ResidualLayout::pattern() const {
  BlockPattern pattern;
  pattern.dims = dims;
  pattern.edges.reserve(residuals.size());
  for (const Residual& residual : residuals) {
    if (!residual.coupled) continue;
    if (pattern.anchor < 0 && residual.count == 1 &&
        residual.rows >= dims[blocks[residual.first]]) {
      pattern.anchor = blocks[residual.first];
    }
    for (int i = 0; i < residual.count; ++i) {
      for (int j = 0; j < i; ++j) {
        pattern.edges.push_back(
            std::minmax(blocks[residual.first + i], blocks[residual.first + j]));
      }
    }
  }
  sort_unique(pattern.edges);
  return pattern;
}

NormalEquations::NormalEquations(const ResidualLayout& layout, Elimination elimination) {
  const BlockPattern pattern = layout.pattern();
  std::vector<int> leaves;
  if (elimination != Elimination::kPlain) leaves = independent_blocks(pattern);
  if (elimination == Elimination::kAutomatic && !schur_pays(pattern, leaves)) leaves.clear();
  if (leaves.empty()) {
    const BlockOrdering ordering = order_blocks(pattern);
    order_ = ordering.order;
    matrix_ = BlockMatrix(pattern, order_, BlockMatrix::Triangle::kLower);
    cholesky_ = BlockCholesky(matrix_, ordering);
  } else {
    const SchurOrdering ordering = order_schur(pattern, leaves);
    order_ = ordering.order;
    matrix_ = BlockMatrix(pattern, order_, BlockMatrix::Triangle::kLower);
    schur_ = SchurCholesky(matrix_, ordering);
  }
  position_.resize(pattern.size());
  for (int p = 0; p < pattern.size(); ++p) position_[order_[p]] = p;
  gradient_.resize(matrix_.scalars());
  diagonal_.resize(matrix_.scalars());
  scale_.resize(matrix_.size());
  bind(layout);
  note_work(kWorkOfBlock * matrix_.block_count());
}

bool NormalEquations::rebind(const ResidualLayout& layout) {
  return bind(layout);
}

bool NormalEquations::bind(const ResidualLayout& layout) {
  // Two passes over the residuals: count the contributions to every block, then place them.
  std::vector<std::uint32_t> diagonal_begin(matrix_.size() + 1, 0);
  std::vector<std::uint32_t> coupling_begin(matrix_.block_count() + 1, 0);
  std::vector<int> found;
  for (const auto& residual : layout.residuals) {
    for (int i = 0; i < residual.count; ++i) {
      const int p = position_[layout.blocks[residual.first + i]];
      ++diagonal_begin[p + 1];
      for (int j = 0; residual.coupled && j < i; ++j) {
        const int block = matrix_.find(p, position_[layout.blocks[residual.first + j]]);
        if (block < 0) return false;
        found.push_back(block);
        ++coupling_begin[block + 1];
      }
    }
  }
  const auto used = std::count_if(coupling_begin.begin(), coupling_begin.end(),
                                  [](std::uint32_t count) { return count > 0; });
  const int couplings = matrix_.block_count() - matrix_.size();
  if (couplings - used > kUnusedShare * couplings) return false;

  std::partial_sum(diagonal_begin.begin(), diagonal_begin.end(), diagonal_begin.begin());
  std::partial_sum(coupling_begin.begin(), coupling_begin.end(), coupling_begin.begin());
  diagonals_.resize(diagonal_begin.back());
  couplings_.resize(coupling_begin.back());
  std::vector<std::uint32_t> next_diagonal(diagonal_begin.begin(), diagonal_begin.end() - 1);
  std::vector<std::uint32_t> next_coupling(coupling_begin.begin(), coupling_begin.end() - 1);
  auto block = found.begin();
  std::vector<std::uint32_t> jacobian;
  for (const auto& residual : layout.residuals) {
    jacobian.assign(1, static_cast<std::uint32_t>(residual.jacobian));
    for (int i = 0; i < residual.count; ++i) {
      const int b = layout.blocks[residual.first + i];
      const int p = position_[b];
      diagonals_[next_diagonal[p]++] = {jacobian[i], static_cast<std::uint32_t>(residual.residual),
                                        residual.rows};
      for (int j = 0; residual.coupled && j < i; ++j, ++block) {
        const bool i_is_row = matrix_.block(*block).row == p;
        couplings_[next_coupling[*block]++] = {i_is_row ? jacobian[i] : jacobian[j],
                                               i_is_row ? jacobian[j] : jacobian[i], residual.rows};
      }
      jacobian.push_back(jacobian.back() + residual.rows * layout.dims[b]);
    }
  }
  diagonal_begin_ = std::move(diagonal_begin);
  coupling_begin_ = std::move(coupling_begin);
  return true;
}

void NormalEquations::assemble(const double* r, const double* J, WorkerPool& pool) {
  const int tasks = (matrix_.size() + kColumnsPerTask - 1) / kColumnsPerTask;
  pool.run(
      tasks,
      [&](int task) {
        const int end = std::min(matrix_.size(), (task + 1) * kColumnsPerTask);
        for (int col = task * kColumnsPerTask; col < end; ++col) assemble_column(col, r, J);
      },
      matrix_.values().size() >= kParallelEntries);
}

void NormalEquations::assemble_column(int col, const double* r, const double* J) {
  const int start = matrix_.start(col);
  const int dim = matrix_.dim(col);
  const int stride = matrix_.stride(col);
  double* values = matrix_.values().data();
  std::fill_n(values + matrix_.column_starts()[start], std::size_t(stride) * dim, 0.0);
  std::fill_n(gradient_.data() + start, dim, 0.0);

  double* block = values + matrix_.block(matrix_.diagonal(col)).offset;
  for (auto k = diagonal_begin_[col]; k < diagonal_begin_[col + 1]; ++k) {
    const Diagonal& d = diagonals_[k];
    const double* jacobian = J + d.jacobian;
    add_product(jacobian, jacobian, d.rows, dim, dim, block, stride);
    for (int c = 0; c < dim; ++c) {
      double sum = 0.0;
      for (int row = 0; row < d.rows; ++row)
        sum += jacobian[c * d.rows + row] * r[d.residual + row];
      gradient_[start + c] += sum;
    }
  }
  scale_[col] = 0.0;
  for (int c = 0; c < dim; ++c) {
    diagonal_[start + c] = values[matrix_.diagonal_offset(start + c)];
    scale_[col] += diagonal_[start + c];
  }
  for (int b = matrix_.block_begin(col); b < matrix_.block_begin(col + 1); ++b) {
    const BlockMatrix::Block& target = matrix_.block(b);
    const int rows_of_block = matrix_.dim(target.row);
    for (auto k = coupling_begin_[b]; k < coupling_begin_[b + 1]; ++k) {
      const Coupling& c = couplings_[k];
      add_product(J + c.row, J + c.col, c.rows, rows_of_block, dim, values + target.offset, stride);
    }
  }
}

int NormalEquations::factorize(double damping, WorkerPool& pool) {
  const double sum = std::accumulate(diagonal_.begin(), diagonal_.end(), 0.0);
  const double floor = sum > 0.0 ? kDiagonalFloor * sum / scalars() : 1.0;
  damping_.assign(scalars(), 0.0);
  for (int i = 0; damping > 0.0 && i < scalars(); ++i) {
    damping_[i] = damping * std::max(diagonal_[i], floor);
  }
  const int scalar = by_schur() ? schur_.factorize(matrix_, damping_.data(), pool)
                                : cholesky_.factorize(matrix_, damping_.data(), pool);
  return scalar < 0 ? -1 : block_of(scalar);
}

const BlockCholesky& NormalEquations::cholesky() const {
  if (by_schur()) throw Error("the factor of the whole system needs Elimination::kPlain");
  return cholesky_;
}

double NormalEquations::smallest_pivot_ratio() const {
  double smallest = 1.0;
  for (int p = 0; p < matrix_.size(); ++p) {
    for (int i = matrix_.start(p); i < matrix_.start(p) + matrix_.dim(p); ++i) {
      const double l = pivot_root(i);
      smallest = std::min(smallest, l * l / scale_[p]);
    }
  }
  return smallest;
}

double NormalEquations::log_determinant() const {
  double sum = 0.0;
  for (int i = 0; i < scalars(); ++i) sum += std::log(pivot_root(i));
  return 2.0 * sum;
}

int NormalEquations::block_of(int scalar) const {
  int low = 0;  // the last block that starts at or before the scalar
  int high = matrix_.size();
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (matrix_.start(middle) <= scalar ? low : high) = middle;
  }
  return order_[low];
}

}  // namespace hybrid
