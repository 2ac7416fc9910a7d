// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/bordered_cholesky.h"

#include <algorithm>
#include <cmath>

#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {

bool BorderedCholesky::append(const double* row, double c, double least) {
  const int n = size();
  const std::size_t first = factor_.size();
  factor_.insert(factor_.end(), row, row + n + 1);
  double* own = factor_.data() + first;
  substitute(own);
  const auto dot = kernels().dot;
  const double pivot = own[n] - dot(own, own, n);
  if (!(pivot >= least) || !std::isfinite(pivot)) {
    factor_.resize(first);
    return false;
  }
  own[n] = std::sqrt(pivot);
  reduced_.push_back((c - dot(own, reduced_.data(), n)) / own[n]);
  return true;
}

void BorderedCholesky::truncate(int size) {
  reduced_.resize(size);
  factor_.resize(static_cast<std::size_t>(size) * (size + 1) / 2);
}

void BorderedCholesky::solve(double* w) const {
  std::copy(reduced_.begin(), reduced_.end(), w);
  for (int i = size() - 1; i >= 0; --i) {
    const double* own = row(i);
    w[i] /= own[i];
    for (int j = 0; j < i; ++j) w[j] -= own[j] * w[i];
  }
}

void BorderedCholesky::substitute(double* x) const {
  const auto dot = kernels().dot;
  for (int i = 0; i < size(); ++i) {
    const double* own = row(i);
    x[i] = (x[i] - dot(own, x, i)) / own[i];
  }
}

double BorderedCholesky::log_determinant() const {
  double sum = 0.0;
  for (int i = 0; i < size(); ++i) sum += std::log(row(i)[i]);
  return 2.0 * sum;
}

}  // namespace hybrid
