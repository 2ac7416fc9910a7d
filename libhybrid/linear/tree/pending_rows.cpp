// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/tree/pending_rows.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "libhybrid/core/paced_task.h"
#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {
namespace {

/// What rows add to the information on what they measure, at most, in units of what the tree has of
/// it: six of sixteen digits are lost then.
constexpr double kMostGain = 1e6;
/// How many times as long a multiplication on the way along a path takes as one in the dense
/// kernels of an elimination, which read each number many times.
constexpr double kSlower = 8.0;
/// Pivots of I + Y' Y are 1 or more but for rounding.
constexpr double kLeastPivot = 0.5;

}  // namespace

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

void PendingRows::pay(double multiplications) {
  note_work(kSlower * multiplications);
  rent_ += kSlower * multiplications;
}

bool PendingRows::add(int factor, const PathRows& Y, const Eigen::VectorXd& c, Cliques& cliques) {
  Generation& all = now();
  const auto count = static_cast<int>(c.size());
  const int before = all.system.size();
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(count, before + count);  // by row of the system
  S.rightCols(count) = Eigen::MatrixXd::Identity(count, count);
  S.rightCols(count).noalias() += Y.z.transpose() * Y.z;
  if (count > 0 && !(S.diagonal(before).maxCoeff() <= kMostGain)) return false;
  pay(double(Y.z.rows()) * count * count);
  int row = 0;
  for (int clique : Y.path) {
    const int dim = cliques[clique].frontal_dim;
    const int at = cliques[clique].pulled;
    const auto own = Y.z.middleRows(row, dim);
    row += dim;
    if (at < 0) continue;
    const Meeting& meeting = all.meetings[at];
    const auto rows = static_cast<Eigen::Index>(meeting.rows.size());
    const Eigen::Map<const Eigen::MatrixXd> others(meeting.Y.data(), dim, rows);
    const Eigen::MatrixXd product = own.transpose() * others;
    for (Eigen::Index k = 0; k < rows; ++k) S.col(meeting.rows[k]) += product.col(k);
    pay(double(dim) * double(rows) * count);
  }
  // From here on an exception leaves what `truncate` takes back.
  all.sets.push_back({factor, before, {}});
  for (int k = 0; k < count; ++k) {
    const Eigen::VectorXd own = S.row(k).head(before + k + 1);
    if (all.system.append(own.data(), c[k], kLeastPivot)) continue;
    truncate(factors() - 1, cliques);
    return false;
  }
  std::vector<int>& meetings = all.sets.back().meetings;
  meetings.reserve(Y.path.size());
  row = 0;
  for (int clique : Y.path) {
    const int dim = cliques[clique].frontal_dim;
    int& at = cliques[clique].pulled;
    if (at < 0) {
      all.meetings.push_back({clique, {}, {}, std::vector<double>(dim, 0.0)});
      at = static_cast<int>(all.meetings.size()) - 1;
    }
    meetings.push_back(at);
    Meeting& meeting = all.meetings[at];
    for (int k = 0; k < count; ++k) {
      const double* own = &Y.z(row, k);
      meeting.rows.push_back(before + k);
      meeting.Y.insert(meeting.Y.end(), own, own + dim);
    }
    row += dim;
  }
  return true;
}

void PendingRows::set_pulls() noexcept {
  Generation& all = now();
  all.w.resize(all.system.size());  // to less, or as it is
  all.system.solve(all.w.data());
  for (Meeting& meeting : all.meetings) {
    std::fill(meeting.pull.begin(), meeting.pull.end(), 0.0);
    const double* column = meeting.Y.data();
    for (int row : meeting.rows) {
      for (double& pull : meeting.pull) pull += *column++ * all.w[row];
    }
  }
}

void PendingRows::pull(Cliques& cliques) {
  if (empty()) return;
  Generation& all = now();
  all.w.resize(all.system.size());
  set_pulls();
  pay(0.5 * double(all.w.size()) * double(all.w.size()));
  for (const Meeting& meeting : all.meetings) {
    const TreeClique& clique = cliques[meeting.clique];
    cliques.set_unsolved(meeting.clique);
    pay(double(meeting.Y.size()) + 2.0 * double(clique.order) * clique.frontal_dim);
  }
}

void PendingRows::add_rows(const TreeClique& clique, const double* y,
                           std::vector<double>& rows) const {
  if (clique.pulled < 0) return;
  const Generation& all = now();
  rows.resize(all.system.size(), 0.0);
  const Meeting& meeting = all.meetings[clique.pulled];
  const double* column = meeting.Y.data();
  for (int row : meeting.rows) {
    rows[row] += std::inner_product(y, y + clique.frontal_dim, column, 0.0);
    column += clique.frontal_dim;
  }
}

Eigen::MatrixXd PendingRows::reduction(const PathRows& rows, const Cliques& cliques) const {
  const Generation& all = now();
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(all.system.size(), rows.z.cols());
  int row = 0;
  for (int clique : rows.path) {
    const int dim = cliques[clique].frontal_dim;
    const auto own = rows.z.middleRows(row, dim);
    row += dim;
    if (cliques[clique].pulled < 0) continue;
    const Meeting& meeting = all.meetings[cliques[clique].pulled];
    const auto count = static_cast<Eigen::Index>(meeting.rows.size());
    const Eigen::Map<const Eigen::MatrixXd> Y(meeting.Y.data(), dim, count);
    const Eigen::MatrixXd product = Y.transpose() * own;
    for (Eigen::Index k = 0; k < count; ++k) X.row(meeting.rows[k]) += product.row(k);
  }
  for (Eigen::Index k = 0; k < X.cols(); ++k) all.system.substitute(X.col(k).data());
  return X;
}

Eigen::MatrixXd PendingRows::reduction(const TreeClique& clique) const {
  const Generation& all = now();
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(all.system.size(), clique.frontal_dim);
  if (clique.pulled < 0) return X.transpose();
  const Meeting& meeting = all.meetings[clique.pulled];
  for (std::size_t k = 0; k < meeting.rows.size(); ++k) {
    const double* column = meeting.Y.data() + k * clique.frontal_dim;
    for (int i = 0; i < clique.frontal_dim; ++i) X(meeting.rows[k], i) = column[i];
  }
  for (Eigen::Index k = 0; k < X.cols(); ++k) all.system.substitute(X.col(k).data());
  return X.transpose();
}

void PendingRows::retire(double price) {
  rent_ = 0.0;
  leaves_ = 0;
  price_ = price;
  if (!empty()) generations_.emplace_back();
}

void PendingRows::truncate(int factors, Cliques& cliques) noexcept {
  Generation& all = now();
  if (factors == this->factors()) return;
  for (; this->factors() > factors; all.sets.pop_back()) {
    const Set& set = all.sets.back();
    for (auto at = set.meetings.rbegin(); at != set.meetings.rend(); ++at) {
      Meeting& meeting = all.meetings[*at];
      const std::size_t dim = meeting.pull.size();
      std::size_t kept = meeting.rows.size();
      // Rows of one factor have numbers above those of the factors before.
      while (kept > 0 && meeting.rows[kept - 1] >= set.first_row) --kept;
      meeting.rows.resize(kept);
      meeting.Y.resize(kept * dim);
      if (kept > 0) continue;
      if (cliques[meeting.clique].pulled == *at) cliques[meeting.clique].pulled = -1;
      all.meetings.pop_back();
    }
    all.system.truncate(set.first_row);
  }
  set_pulls();
}

void PendingRows::commit() noexcept {
  generations_.erase(generations_.begin(), generations_.end() - 1);
}

void PendingRows::roll_back(const Mark& mark, Cliques& cliques, LinearSystem& system) noexcept {
  for (; generations_.size() > mark.generation; generations_.pop_back()) truncate(0, cliques);
  truncate(mark.factors, cliques);
  for (const Set& set : now().sets) system.set_factor_clique(set.factor, LinearSystem::kPending);
  rent_ = mark.rent;
  price_ = mark.price;
  leaves_ = mark.leaves;
}

std::size_t PendingRows::bytes() const {
  std::size_t bytes = now().system.bytes();
  for (const Meeting& meeting : now().meetings) {
    bytes += sizeof(Meeting) + (meeting.Y.capacity() + meeting.pull.capacity()) * sizeof(double) +
             meeting.rows.capacity() * sizeof(int);
  }
  return bytes;
}

}  // namespace hybrid
