// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/tree/clique_charts.h"

#include <algorithm>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/linear/with_dim.h"

namespace hybrid {
namespace {

/// to += from D for a block of N columns, or n if N is Eigen::Dynamic.
template <int N>
void add_product(const double* from, const double* D, int rows, int n, int columns, double* to) {
  using Wide = Eigen::Matrix<double, Eigen::Dynamic, N>;
  using Square = Eigen::Matrix<double, N, Eigen::Dynamic>;
  const Eigen::Map<const Wide> source(from, rows, N > 0 ? N : n);
  const Eigen::Map<const Square> by(D, N > 0 ? N : n, columns);
  Eigen::Map<Eigen::MatrixXd> target(to, rows, columns);
  target.noalias() += source.lazyProduct(by);
}

void add_product(const double* from, const double* D, int rows, int n, int columns, double* to) {
  with_dim(n,
           [&](auto known) { add_product<decltype(known)::value>(from, D, rows, n, columns, to); });
}

/// H' = T' H T in place for a packed H of order n: T has the N x N blocks `own` on its diagonal and
/// 1 at its end. `panel` is scratch.
template <int N>
void turn_blocks(double* packed, int n, const double* own, std::vector<double>& panel) {
  using Square = Eigen::Matrix<double, N, N>;
  using Wide = Eigen::Matrix<double, Eigen::Dynamic, N>;
  for (int first = 0; first + N < n; first += N) {
    const int height = n - first;
    panel.resize(2 * static_cast<std::size_t>(height) * N);
    Eigen::Map<Wide> in(panel.data(), height, N);
    Eigen::Map<Wide> out(panel.data() + static_cast<std::size_t>(height) * N, height, N);
    for (int c = 0; c < N; ++c) {
      const double* column = packed_column(packed, std::size_t(n), std::size_t(first) + c) + first;
      std::copy(column + c, column + height, &in(c, c));
      for (int r = c + 1; r < N; ++r) in(c, r) = column[r];
    }
    out.noalias() = in.lazyProduct(Eigen::Map<const Square>(own + first * N));
    for (int row = 0; row + N < height; row += N) {
      const Square turned = Eigen::Map<const Square>(own + (first + row) * N)
                                .transpose()
                                .lazyProduct(Square(out.template middleRows<N>(row)));
      in.template middleRows<N>(row) = turned;
    }
    in.row(height - 1) = out.row(height - 1);
    for (int c = 0; c < N; ++c) {
      double* column = packed_column(packed, std::size_t(n), std::size_t(first) + c) + first;
      std::copy(&in(c, c), &in(0, c) + height, column + c);
    }
  }
}

}  // namespace

bool find_motion(const TreeClique& clique, const Charts& charts, CliqueMotion& motion) {
  const Chart chart = clique.chart();
  if (!clique.free || !charts.find_motion(clique.variables, clique.frontals, chart, clique.seen(),
                                          clique.scales(), motion.newest))
    return false;
  std::copy_n(chart.motion, motion.in_all.size(), motion.in_all.begin());
  charts.add(motion.newest, motion.in_all.data());
  return true;
}

const double* HessianCarrier::carry(const LinearSystem& system, const Charts& charts,
                                    const TreeClique& clique, Chart chart) {
  const double* hessian = clique.update(0);
  const int first = clique.frontals;
  const int order = clique.separator_dim() + 1;
  const std::size_t size = order;
  steps_.resize(size);
  charts.see(clique.variables, first, first, chart, steps_.data(), turn_);
  steps_[size - 1] = 1.0;
  if (!chart.is_moved() &&
      std::all_of(steps_.begin(), steps_.end() - 1, [](double x) { return x == 0.0; }))
    return hessian;
  carried_.assign(hessian, hessian + packed_size(size));
  const int dim = system.dim(clique.variables[first]);
  const bool alike =
      turn_.anchor < 0 && std::all_of(clique.variables.begin() + first, clique.variables.end(),
                                      [&](int v) { return system.dim(v) == dim; });
  if (alike && (dim == 3 || dim == 6)) {
    shift(order);
    dim == 3 ? turn_blocks<3>(carried_.data(), order, turn_.own.data(), product_)
             : turn_blocks<6>(carried_.data(), order, turn_.own.data(), product_);
    return carried_.data();
  }
  square_.resize(size * size);
  Eigen::Map<Eigen::MatrixXd> H(square_.data(), order, order);
  for (int j = 0; j < order; ++j) {
    const double* column = packed_column(hessian, size, j);
    for (int i = j; i < order; ++i) H(i, j) = H(j, i) = column[i];
  }
  product_.resize(size * size);
  Eigen::Map<Eigen::MatrixXd> P(product_.data(), order, order);
  for (int side = 0; side < 2; ++side) {
    times_turn(system, clique);
    H = P.transpose();
  }
  for (int j = 0; j < order; ++j) {
    std::copy_n(&H(j, j), order - j, packed_column(carried_.data(), size, j) + j);
  }
  return carried_.data();
}

/// Adds to the right-hand side in carried_ what the steps are worth.
void HessianCarrier::shift(int order) {
  const int s = order - 1;
  product_.assign(s, 0.0);
  Eigen::Map<Eigen::VectorXd> shift(product_.data(), s);
  const Eigen::Map<const Eigen::VectorXd> steps(steps_.data(), s);
  for (int j = 0; j < s; ++j) {
    const double* column = packed_column(carried_.data(), std::size_t(order), std::size_t(j));
    const Eigen::Map<const Eigen::VectorXd> below(column + j + 1, s - j - 1);
    shift[j] += column[j] * steps[j] + below.dot(steps.tail(s - j - 1));
    shift.tail(s - j - 1) += steps[j] * below;
  }
  for (int j = 0; j < s; ++j)
    packed_column(carried_.data(), std::size_t(order), std::size_t(j))[s] += shift[j];
}

/// product_ = square_ T, with T = [turn_, steps_; 0, 1].
void HessianCarrier::times_turn(const LinearSystem& system, const TreeClique& clique) {
  std::fill(product_.begin(), product_.end(), 0.0);
  const std::size_t size = steps_.size();
  const auto order = static_cast<int>(size);
  const TurnedVariables turned{system, clique, turn_, clique.frontals};
  const int anchor_dim = turned.anchor_dim();
  double* anchor = product_.data() + size * turned.anchor_row();
  turned.for_each([&](int, int row, int dim, const double* own, const double* by) {
    const double* from = square_.data() + size * row;
    add_product(from, own, order, dim, dim, product_.data() + size * row);
    if (by != nullptr) add_product(from, by, order, dim, anchor_dim, anchor);
  });
  add_product(square_.data(), steps_.data(), order, order, 1, product_.data() + size * (size - 1));
}

}  // namespace hybrid
