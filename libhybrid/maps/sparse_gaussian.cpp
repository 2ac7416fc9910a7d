// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/sparse_gaussian.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "libhybrid/core/error.h"
#include "libhybrid/maps/detail/sparse_rows.h"

namespace hybrid {
namespace {

double log_det(const Eigen::LLT<Eigen::MatrixXd>& llt) {
  return 2 * llt.matrixL().toDenseMatrix().diagonal().array().log().sum();
}

Eigen::LLT<Eigen::MatrixXd> factorised(const Eigen::MatrixXd& covariance) {
  Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  if (llt.info() != Eigen::Success) {
    throw Error("the joint covariance of the landmarks is not positive definite");
  }
  return llt;
}

/// Rows and columns of some landmarks.
Eigen::MatrixXd part(const Eigen::MatrixXd& covariance, const std::vector<int>& of, int dim) {
  const auto n = static_cast<Eigen::Index>(of.size());
  Eigen::MatrixXd out(dim * n, dim * n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      out.block(dim * a, dim * b, dim, dim) = covariance.block(dim * of[a], dim * of[b], dim, dim);
    }
  }
  return out;
}

/// The blocks of the joint covariance that those of single landmarks follow from, landmark by
/// landmark: each landmark with those before it that the elimination of later ones couples it to.
class CoupledBlocks {
 public:
  explicit CoupledBlocks(const SparseGaussian& all) : all_(all), before_(all.rows.size()) {
    for (std::size_t i = before_.size(); i-- > 0;) {
      std::vector<int>& own = before_[i];
      const std::vector<int>& variables = all.rows[i].variables;
      own.insert(own.end(), variables.begin() + 1, variables.end());
      std::sort(own.begin(), own.end());
      own.erase(std::unique(own.begin(), own.end()), own.end());
      if (own.empty()) continue;
      std::vector<int>& next = before_[static_cast<std::size_t>(own.back())];
      next.insert(next.end(), own.begin(), own.end() - 1);
    }
    blocks_.resize(before_.size());
    for (std::size_t i = 0; i < before_.size(); ++i) fill(static_cast<int>(i));
  }

  /// Covariance of two landmarks, of which one couples to the other.
  Eigen::MatrixXd at(int a, int b) const {
    if (a < b) return at(b, a).transpose();
    const std::vector<int>& own = before_[static_cast<std::size_t>(a)];
    const auto place = std::lower_bound(own.begin(), own.end(), b) - own.begin();
    return blocks_[static_cast<std::size_t>(a)].middleCols(all_.dim * place, all_.dim);
  }

 private:
  /// The row of a landmark, itself last: x_i = W (w - sum of R_k x_given(k)), w being N(0, I).
  void fill(int i) {
    const int dim = all_.dim;
    const SparseRow& row = all_.rows[static_cast<std::size_t>(i)];
    const std::vector<int>& own = before_[static_cast<std::size_t>(i)];
    const Eigen::MatrixXd W = row.R.leftCols(dim).inverse();
    const Eigen::MatrixXd B = -W * row.R;
    const auto with = [&](int h) {
      Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(dim, dim);
      for (std::size_t k = 1; k < row.variables.size(); ++k) {
        sum += B.middleCols(dim * static_cast<Eigen::Index>(k), dim) * at(row.variables[k], h);
      }
      return sum;
    };
    Eigen::MatrixXd& out = blocks_[static_cast<std::size_t>(i)];
    out.resize(dim, dim * static_cast<Eigen::Index>(own.size() + 1));
    for (std::size_t k = 0; k < own.size(); ++k) {
      out.middleCols(dim * static_cast<Eigen::Index>(k), dim) = with(own[k]);
    }
    Eigen::MatrixXd variance = W * W.transpose();
    for (std::size_t k = 1; k < row.variables.size(); ++k) {
      variance += at(i, row.variables[k]) *
                  B.middleCols(dim * static_cast<Eigen::Index>(k), dim).transpose();
    }
    out.rightCols(dim) = variance;
  }

  const SparseGaussian& all_;
  std::vector<std::vector<int>> before_;
  std::vector<Eigen::MatrixXd> blocks_;
};

}  // namespace

std::vector<int> nearest_to(const Eigen::MatrixXd& covariance, int i, int dim) {
  std::vector<std::pair<double, int>> ranked;
  for (int j = 0; j < i; ++j) {
    const double variance = covariance.block(dim * i, dim * i, dim, dim).trace() +
                            covariance.block(dim * j, dim * j, dim, dim).trace() -
                            2 * covariance.block(dim * i, dim * j, dim, dim).trace();
    ranked.emplace_back(variance, j);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<int> out;
  for (const auto& [variance, j] : ranked) out.push_back(j);
  return out;
}

SparseRow row_of(const Eigen::MatrixXd& covariance, int i, const std::vector<int>& near, int given,
                 int dim) {
  SparseRow row;
  row.variables.push_back(i);
  for (int k = 0; k < given && k < static_cast<int>(near.size()); ++k) {
    row.variables.push_back(near[static_cast<std::size_t>(k)]);
  }
  // The last rows of the inverse of the lower factor, the landmark being last.
  std::vector<int> order(row.variables.rbegin(), row.variables.rend());
  const auto llt = factorised(part(covariance, order, dim));
  const Eigen::Index n = dim * static_cast<Eigen::Index>(order.size());
  Eigen::MatrixXd last = Eigen::MatrixXd::Zero(n, dim);
  last.bottomRows(dim).setIdentity();
  const Eigen::MatrixXd L = llt.matrixL();
  const Eigen::MatrixXd rows = L.transpose().triangularView<Eigen::Upper>().solve(last).transpose();
  row.R.resize(dim, n);
  for (Eigen::Index k = 0; k * dim < n; ++k) {
    row.R.middleCols(k * dim, dim) = rows.middleCols(n - (k + 1) * dim, dim);
  }
  return row;
}

std::vector<Eigen::MatrixXd> SparseGaussian::covariances() const {
  const CoupledBlocks blocks(*this);
  std::vector<Eigen::MatrixXd> out;
  for (int i = 0; i < static_cast<int>(rows.size()); ++i) out.push_back(blocks.at(i, i));
  return out;
}

Eigen::MatrixXd SparseGaussian::covariance() const {
  const Eigen::Index n = dim * static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n, n);  // lower triangular
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t k = 0; k < rows[i].variables.size(); ++k) {
      R.block(dim * static_cast<Eigen::Index>(i), dim * rows[i].variables[k], dim, dim) =
          rows[i].R.middleCols(dim * static_cast<Eigen::Index>(k), dim);
    }
  }
  const Eigen::MatrixXd inverse =
      R.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(n, n));
  return inverse * inverse.transpose();
}

SparseGaussian sparsify(const Eigen::MatrixXd& covariance, int dim, double most_loss) {
  SparseGaussian out;
  out.dim = dim;
  const int n = static_cast<int>(covariance.rows()) / dim;
  if (n == 0) return out;
  const double exact = log_det(factorised(covariance));
  std::vector<std::vector<int>> near;
  for (int i = 0; i < n; ++i) near.push_back(nearest_to(covariance, i, dim));
  for (int given = kFewestGiven;; given *= 2) {
    out.rows.clear();
    double log_det_sparse = 0;
    for (int i = 0; i < n; ++i) {
      out.rows.push_back(row_of(covariance, i, near[static_cast<std::size_t>(i)], given, dim));
      log_det_sparse -= 2 * out.rows.back().R.leftCols(dim).diagonal().array().log().sum();
    }
    out.loss = std::max(0.0, 0.5 * (log_det_sparse - exact));
    if (out.loss <= most_loss || given >= n - 1) return out;
  }
}

}  // namespace hybrid
