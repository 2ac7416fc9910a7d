// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/sparse_gaussian.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/factors/linear_factor.h"
#include "libhybrid/linear/path_inverse.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/marginals/log_determinant.h"
#include "libhybrid/solvers/null_space.h"

namespace hybrid {
namespace {

constexpr int kFewestGiven = 4;           // landmarks that one is given
constexpr std::size_t kMostDense = 1000;  // points, whose joint covariance has at most 72 MB
constexpr int kCandidates = 2;            // times as many points as one is given
constexpr int kMostGiven = 32;            // points that one is given

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

/// The landmarks before `i` of a joint covariance by the variance of their place relative to it.
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

/// The density of landmark `i` given the first `given` of `near`.
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

/// Of each factor what it says of some variables, the others being held.
HybridGraph conditioned(const HybridGraph& graph, const Values& values,
                        const std::unordered_set<Key>& variables) {
  HybridGraph out;
  graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    const auto& keys = factor->keys();
    if (std::none_of(keys.begin(), keys.end(), [&](Key k) { return variables.count(k) > 0; })) {
      return;
    }
    Eigen::VectorXd r(factor->rows());
    Eigen::MatrixXd J(factor->rows(), factor->cols());
    factor->linearize(gather(keys, factor->types(), values).data(), r.data(), J.data());
    std::vector<LinearFactor::Term> terms;
    int column = 0;
    for (std::size_t k = 0; k < keys.size(); ++k) {
      const int width = factor->types()[k].dim;
      if (variables.count(keys[k]) > 0) terms.push_back({keys[k], J.middleCols(column, width)});
      column += width;
    }
    out.emplace<LinearFactor>(terms, Eigen::VectorXd::Zero(factor->rows()),
                              Noise::unit(factor->rows()));
  });
  return out;
}

/// Joint covariances of points of a graph, from its sparse factor.
class GraphCovariance {
 public:
  GraphCovariance(const HybridGraph& graph, const Values& values, std::vector<Key> points, int dim)
      : points_(std::move(points)),
        dim_(dim),
        problem_(graph, values, {}, 0, WeakComponents::kCoupled, Elimination::kPlain) {
    problem_.linearize(problem_.load(values));
    problem_.assemble();
    if (!is_clearly_regular(problem_)) {
      throw Error("the joint density of the landmarks is nearly singular");
    }
    inverse_ = std::make_unique<PathInverse>(problem_.system().cholesky());
    log_det_ = -problem_.system().log_determinant();
    std::unordered_set<Key> others;
    for (int block = 0; block < problem_.block_count(); ++block) {
      others.insert(problem_.key(block));
    }
    for (const Key point : points_) others.erase(point);
    if (others.empty()) return;
    const HybridGraph rest = conditioned(graph, values, others);
    Values zero;
    for (const Key key : others) {
      zero.insert(key, Eigen::VectorXd(Eigen::VectorXd::Zero(values.type(key).dim)));
    }
    Problem held(rest, zero, {}, 0, WeakComponents::kCoupled);
    held.linearize(held.load(zero));
    log_det_ += log_determinant(held).value;
  }

  /// log of the determinant of the joint covariance of all points.
  double log_det() const { return log_det_; }

  /// Of some points, by their places in the list.
  Eigen::MatrixXd of(const std::vector<int>& some) {
    const auto n = static_cast<Eigen::Index>(some.size());
    Eigen::MatrixXd out(dim_ * n, dim_ * n);
    for (Eigen::Index a = 0; a < n; ++a) {
      for (Eigen::Index b = 0; b <= a; ++b) {
        const auto block =
            block_of(some[static_cast<std::size_t>(a)], some[static_cast<std::size_t>(b)]);
        out.block(dim_ * a, dim_ * b, dim_, dim_) = block;
        out.block(dim_ * b, dim_ * a, dim_, dim_) = block.transpose();
      }
    }
    return out;
  }

 private:
  /// The covariance of two points; those near by are asked for again and again.
  Eigen::MatrixXd block_of(int a, int b) {
    if (a < b) return block_of(b, a).transpose();
    const auto pair = static_cast<std::uint64_t>(a) << 32U | static_cast<std::uint64_t>(b);
    const auto [known, is_new] = places_.try_emplace(pair, blocks_.size());
    if (is_new) {
      const Eigen::MatrixXd block = inverse_->block(start(a), dim_, start(b), dim_);
      blocks_.insert(blocks_.end(), block.data(), block.data() + block.size());
    }
    return Eigen::Map<const Eigen::MatrixXd>(blocks_.data() + known->second, dim_, dim_);
  }
  int start(int point) const {
    return problem_.system().start(problem_.block(points_[static_cast<std::size_t>(point)]));
  }

  std::vector<Key> points_;
  int dim_;
  Problem problem_;
  std::unique_ptr<PathInverse> inverse_;
  std::unordered_map<std::uint64_t, std::size_t> places_;  // of pairs
  std::vector<double> blocks_;
  double log_det_ = 0;
};

/// The points before one that are nearest to it.
std::vector<int> candidates(const std::vector<Eigen::VectorXd>& places, int i, int given) {
  std::vector<std::pair<double, int>> near;
  for (int j = 0; j < i; ++j) {
    near.emplace_back(
        (places[static_cast<std::size_t>(j)] - places[static_cast<std::size_t>(i)]).squaredNorm(),
        j);
  }
  const std::size_t count = std::min<std::size_t>(kCandidates * given, near.size());
  std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
  std::vector<int> out;
  for (std::size_t k = 0; k < count; ++k) out.push_back(near[k].second);
  return out;
}

/// The density of one point given some of its candidates.
SparseRow row_among(GraphCovariance& covariance, std::vector<int> some, int i, int given, int dim) {
  some.push_back(i);
  const Eigen::MatrixXd joint = covariance.of(some);
  const int last = static_cast<int>(some.size()) - 1;
  SparseRow row = row_of(joint, last, nearest_to(joint, last, dim), given, dim);
  for (int& variable : row.variables) variable = some[static_cast<std::size_t>(variable)];
  return row;
}

}  // namespace

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

SparseGaussian sparsify(const HybridGraph& graph, const Values& values,
                        const std::vector<Key>& points, int dim, double most_loss) {
  if (points.size() <= kMostDense) {
    const ContinuousMarginals marginals(graph, {values, {}});
    return sparsify(marginals.joint_covariance(points), dim, most_loss);
  }
  GraphCovariance covariance(graph, values, points, dim);
  std::vector<Eigen::VectorXd> places;
  for (const Key point : points) places.push_back(values.vector(point));
  SparseGaussian out;
  out.dim = dim;
  for (int given = kFewestGiven;; given *= 2) {
    out.rows.clear();
    double log_det = 0;
    for (int i = 0; i < static_cast<int>(points.size()); ++i) {
      out.rows.push_back(row_among(covariance, candidates(places, i, given), i, given, dim));
      log_det -= 2 * out.rows.back().R.leftCols(dim).diagonal().array().log().sum();
    }
    out.loss = std::max(0.0, 0.5 * (log_det - covariance.log_det()));
    if (out.loss <= most_loss || given >= kMostGiven) return out;
  }
}

}  // namespace hybrid
