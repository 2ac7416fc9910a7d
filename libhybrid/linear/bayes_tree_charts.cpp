// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Hessians in the tangents at the estimates, and subtrees that move with the map.
#include <Eigen/Core>
#include <algorithm>

#include "libhybrid/linear/bayes_tree.h"
#include "libhybrid/linear/detail/with_dim.h"

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

/// A Hessian was made about the points of a chart. About the estimates it is the same quadratic
/// form of the steps from there, H' = T' H T with T = [turn, steps; 0, 1]. Leaves it in carried_.
void BayesTree::carry_over(const std::vector<int>& variables, int first, Chart chart,
                           const double* hessian, int order, const Charts& charts) {
  const std::size_t size = order;
  view_.resize(size);
  charts.see(variables, first, first, chart, view_.data(), turn_);
  view_[size - 1] = 1.0;
  carried_.assign(hessian, hessian + packed_size(size));
  if (!chart.is_moved() &&
      std::all_of(view_.begin(), view_.end() - 1, [](double x) { return x == 0.0; }))
    return;
  const int dim = variables_[variables[first]].dim;
  const bool alike =
      turn_.anchor < 0 && std::all_of(variables.begin() + first, variables.end(),
                                      [&](int v) { return variables_[v].dim == dim; });
  if (alike && (dim == 3 || dim == 6)) {
    shift_carried(order);
    dim == 3 ? turn_blocks<3>(carried_.data(), order, turn_.own.data(), product_)
             : turn_blocks<6>(carried_.data(), order, turn_.own.data(), product_);
    return;
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
    times_turn(variables, first, order);
    H = P.transpose();
  }
  for (int j = 0; j < order; ++j) {
    std::copy_n(&H(j, j), order - j, packed_column(carried_.data(), size, j) + j);
  }
}

/// Adds to the right-hand side in carried_ what the steps in view_ are worth.
void BayesTree::shift_carried(int order) {
  const int s = order - 1;
  product_.assign(s, 0.0);
  Eigen::Map<Eigen::VectorXd> shift(product_.data(), s);
  const Eigen::Map<const Eigen::VectorXd> view(view_.data(), s);
  for (int j = 0; j < s; ++j) {
    const double* column = packed_column(carried_.data(), std::size_t(order), std::size_t(j));
    const Eigen::Map<const Eigen::VectorXd> below(column + j + 1, s - j - 1);
    shift[j] += column[j] * view[j] + below.dot(view.tail(s - j - 1));
    shift.tail(s - j - 1) += view[j] * below;
  }
  for (int j = 0; j < s; ++j)
    packed_column(carried_.data(), std::size_t(order), std::size_t(j))[s] += shift[j];
}

/// product_ = square_ T, with T = [turn_, view_; 0, 1].
void BayesTree::times_turn(const std::vector<int>& variables, int first, int order) {
  std::fill(product_.begin(), product_.end(), 0.0);
  const std::size_t size = order;
  const double *own = turn_.own.data(), *by = turn_.by_anchor.data();
  double* anchor = nullptr;
  int anchor_dim = 0;
  if (turn_.anchor >= 0) {
    anchor = product_.data();
    anchor_dim = variables_[variables[turn_.anchor]].dim;
    for (int k = first; k < turn_.anchor; ++k) anchor += size * variables_[variables[k]].dim;
  }
  const double* from = square_.data();
  double* to = product_.data();
  for (std::size_t k = first; k < variables.size(); ++k) {
    const int dim = variables_[variables[k]].dim;
    add_product(from, own, order, dim, dim, to);
    if (anchor != nullptr) {
      if (dim < anchor_dim) add_product(from, by, order, dim, anchor_dim, anchor);
      by += static_cast<std::ptrdiff_t>(dim) * anchor_dim;
    }
    own += static_cast<std::ptrdiff_t>(dim) * dim;
    from += size * dim;
    to += size * dim;
  }
  add_product(square_.data(), view_.data(), order, order, 1, to);
}

/// The steps of a clique's separator as it is now: as its chart sees it, or those of the variables.
void BayesTree::see(const Clique& clique, const Charts* charts) {
  view_.resize(clique.separator_dim());
  if (charts != nullptr) {
    charts->see(clique.variables, clique.frontals, clique.chart(), view_.data());
    return;
  }
  double* to = view_.data();
  for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k) {
    const VariableState& variable = variables_[clique.variables[k]];
    to = std::copy_n(deltas_.at(variable.delta), variable.dim, to);
  }
}

/// By how much the objective may rise, at most, where all below a clique stays though its separator
/// has come to what is seen: by the information that the factors below have of it.
double BayesTree::strain(const Clique& clique, const std::vector<double>& view) const {
  const double* scale = clique.scales();
  const double* seen = clique.seen();
  const double* now = view.data();
  double strain = 0.0;
  for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k, ++scale) {
    const int dim = variables_[clique.variables[k]].dim;
    double square = 0.0;
    for (int i = 0; i < dim; ++i, ++seen, ++now) square += (*now - *seen) * (*now - *seen);
    strain += *scale * square;
  }
  return 0.5 * strain;
}

/// Finds the motion of the map after which a clique sees its separator as it has seen it. Returns
/// false where the clique is held in the map, or sees too little.
bool BayesTree::find_motion(const Clique& clique, const Charts& charts) {
  if (!clique.free) return false;
  const Chart chart = clique.chart();
  if (!charts.find_motion(clique.variables, clique.frontals, chart, clique.seen(), clique.scales(),
                          follow_.motion))
    return false;
  std::copy_n(chart.motion, follow_.in_all.size(), follow_.in_all.begin());
  charts.add(follow_.motion, follow_.in_all.data());
  return true;
}

/// The same, and what it sees then.
bool BayesTree::follow(const Clique& clique, const Charts& charts) {
  if (!find_motion(clique, charts)) return false;
  follow_.view.resize(clique.separator_dim());
  charts.see(clique.variables, clique.frontals, {follow_.in_all.data(), clique.chart().points},
             follow_.view.data());
  return true;
}

/// Moves all below a clique.
void BayesTree::move_below(int c, const MapMotion& motion, Charts& charts) {
  below_.assign(cliques_[c].children.begin(), cliques_[c].children.end());
  while (!below_.empty()) {
    const int b = below_.back();
    below_.pop_back();
    Clique& clique = cliques_[b];
    save_motion(b);
    charts.add(motion, clique.motion());
    charts.move(clique.variables, clique.frontals, motion);
    below_.insert(below_.end(), clique.children.begin(), clique.children.end());
  }
}

/// Whether a clique and all below it may be left while it sees its separator as given: what that
/// costs at most is little for so many factors, and what it costs, `rise()`, is no more than is
/// left for it of what the new steps bring. Without the latter, a part of 100,000 factors would
/// stay at a cost of a hundred beside steps that bring one.
template <class Rise>
bool BayesTree::may_bend(const Clique& clique, const std::vector<double>& view, const Bend& bend,
                         const Rise& rise) {
  const double most = strain(clique, view);
  if (most <= bend.whole) return true;
  if (most > bend.whole + bend.per_factor * clique.factors_below) return false;
  const double cost = rise();
  if (cost > may_rise_) return false;
  may_rise_ -= cost;
  return true;
}

/// By how much the linearised objective rises where a clique, which sees its separator as in view_,
/// and all below it stay: the sum over the cliques that see something else than they have seen,
/// from level to level of the tree. Where a level adds less than half of the one above, those below
/// count as a geometric series. Ends at more than may be spent.
double BayesTree::rise_of_staying(int c, const Bend& bend, const Charts* charts) {
  double rise = 0.0, above = 0.0;
  std::vector<int> level{c};
  while (!level.empty() && rise <= may_rise_) {
    double own = 0.0;
    below_.clear();
    for (std::size_t k = 0; k < level.size() && rise + own <= may_rise_; ++k) {
      const Clique& clique = cliques_[level[k]];
      see(clique, charts);
      if (strain(clique, view_) <= bend.whole) continue;
      own += prepare(clique, view_.data());
      below_.insert(below_.end(), clique.children.begin(), clique.children.end());
    }
    rise += own;
    if (2.0 * own < above) {
      rise += own * own / (above - own);
      break;
    }
    above = own;
    level.swap(below_);
  }
  see(cliques_[c], charts);
  return rise;
}

/// Whether a clique and all below it stay as they are, moved with their separator where they may.
/// Otherwise it has noted what it sees.
bool BayesTree::is_left(int c, const Bend& bend, Charts* charts) {
  Clique& clique = cliques_[c];
  see(clique, charts);
  follow_.found = false;
  const bool is_as_before = !clique.pending && clique.visit == Clique::Visit::kNone;
  if (is_as_before &&
      may_bend(clique, view_, bend, [&] { return rise_of_staying(c, bend, charts); }))
    return true;
  follow_.found = charts != nullptr && is_as_before && follow(clique, *charts);
  if (follow_.found &&
      may_bend(clique, follow_.view, bend, [&] { return prepare(clique, follow_.view.data()); })) {
    save_motion(c);
    std::copy(follow_.in_all.begin(), follow_.in_all.end(), clique.motion());
    charts->move(clique.variables, clique.frontals, follow_.motion);
    move_below(c, follow_.motion, *charts);
    list_changed(clique, clique.frontals, clique.variables.size());  // what moves past them
    return true;
  }
  save_seen(c);
  std::copy(view_.begin(), view_.end(), clique.seen());
  return false;
}

/// Notes which of the new cliques, children before their parents, may move with their separator.
void BayesTree::set_free(const std::vector<int>& made, const Charts& charts) {
  for (int c : made) {
    Clique& clique = cliques_[c];
    const auto end = clique.variables.begin() + clique.frontals;
    clique.free =
        std::none_of(clique.variables.begin(), end, [&](int v) { return charts.is_held(v); }) &&
        std::all_of(clique.children.begin(), clique.children.end(),
                    [&](int child) { return cliques_[child].free; });
  }
}

}  // namespace hybrid
