// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/cholesky.h"

#include <cholmod.h>

#include <algorithm>
#include <cmath>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

/// A CHOLMOD view of the matrix; nothing is copied, and CHOLMOD does not write to it.
cholmod_sparse view(const BlockMatrix& matrix) {
  cholmod_sparse a{};
  a.nrow = a.ncol = matrix.scalars();
  a.nzmax = matrix.rows().size();
  a.p = const_cast<int*>(matrix.column_starts().data());
  a.i = const_cast<int*>(matrix.rows().data());
  a.x = const_cast<double*>(matrix.values().data());
  a.stype = matrix.triangle() == BlockMatrix::Triangle::kLower ? -1 : 1;
  a.itype = CHOLMOD_INT;
  a.xtype = CHOLMOD_REAL;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = a.packed = 1;
  return a;
}

cholmod_dense dense_view(double* x, int rows, int columns) {
  cholmod_dense b{};
  b.nrow = b.d = rows;
  b.ncol = columns;
  b.nzmax = std::size_t(rows) * columns;
  b.x = x;
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  return b;
}

}  // namespace

struct Cholesky::Impl {
  cholmod_common common;
  cholmod_factor* factor = nullptr;
  cholmod_dense* solution = nullptr;  // workspaces of the back-substitution
  cholmod_dense* workspace = nullptr;
  cholmod_dense* extra = nullptr;

  Impl() { cholmod_start(&common); }
  ~Impl() {
    cholmod_free_factor(&factor, &common);
    cholmod_free_dense(&solution, &common);
    cholmod_free_dense(&workspace, &common);
    cholmod_free_dense(&extra, &common);
    cholmod_finish(&common);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
};

Cholesky::Cholesky() = default;
Cholesky::~Cholesky() = default;
Cholesky::Cholesky(Cholesky&&) noexcept = default;
Cholesky& Cholesky::operator=(Cholesky&&) noexcept = default;

Cholesky::Cholesky(const BlockMatrix& matrix) : impl_(std::make_unique<Impl>()) {
  cholmod_common& common = impl_->common;
  common.print = 0;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_NATURAL;
  common.postorder = 0;  // the order of the blocks is a postorder already
  common.supernodal = CHOLMOD_AUTO;
  common.final_ll = 1;
  cholmod_sparse a = view(matrix);
  impl_->factor = cholmod_analyze(&a, &common);
  if (impl_->factor == nullptr) {
    throw Error("symbolic analysis of a system of " + std::to_string(matrix.scalars()) +
                " unknowns failed: out of memory or too large");
  }
}

int Cholesky::factorize(const BlockMatrix& matrix) {
  cholmod_sparse a = view(matrix);
  cholmod_factor* factor = impl_->factor;
  cholmod_factorize(&a, factor, &impl_->common);
  if (impl_->common.status < CHOLMOD_OK) {
    throw Error("factorisation of a system of " + std::to_string(matrix.scalars()) +
                " unknowns ran out of memory");
  }
  if (factor->minor < factor->n) return static_cast<int>(factor->minor);
  // With some BLAS libraries a NaN passes CHOLMOD's test of the pivots.
  const std::vector<double> all = pivots();
  const auto bad = std::find_if_not(all.begin(), all.end(),
                                    [](double p) { return std::isfinite(p) && p > 0.0; });
  return bad == all.end() ? -1 : static_cast<int>(bad - all.begin());
}

void Cholesky::solve(double* x, int columns) {
  const int n = static_cast<int>(impl_->factor->n);
  cholmod_dense b = dense_view(x, n, columns);
  if (impl_->solution != nullptr && impl_->solution->ncol != std::size_t(columns)) {
    cholmod_free_dense(&impl_->solution, &impl_->common);
  }
  cholmod_solve2(CHOLMOD_A, impl_->factor, &b, nullptr, &impl_->solution, nullptr,
                 &impl_->workspace, &impl_->extra, &impl_->common);
  const double* y = static_cast<const double*>(impl_->solution->x);
  std::copy(y, y + std::size_t(n) * columns, x);
}

std::vector<double> Cholesky::pivots() const {
  const cholmod_factor& factor = *impl_->factor;
  const int n = static_cast<int>(factor.n);
  const double* x = static_cast<const double*>(factor.x);
  std::vector<double> result(n);
  if (factor.is_super) {
    const int* super = static_cast<const int*>(factor.super);
    const int* pi = static_cast<const int*>(factor.pi);
    const int* px = static_cast<const int*>(factor.px);
    for (std::size_t s = 0; s < factor.nsuper; ++s) {
      const std::size_t height = pi[s + 1] - pi[s];
      for (int j = super[s]; j < super[s + 1]; ++j) {
        const double l = x[px[s] + (j - super[s]) * (height + 1)];
        result[j] = l * l;
      }
    }
  } else {
    const int* p = static_cast<const int*>(factor.p);
    for (int j = 0; j < n; ++j) result[j] = x[p[j]] * x[p[j]];
  }
  return result;
}

}  // namespace hybrid
