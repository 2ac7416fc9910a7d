// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/joint_compatibility.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "libhybrid/core/chi_square.h"

namespace hybrid {
namespace {

class Search {
 public:
  Search(const PredictedSightings& predicted, const std::vector<MeasuredPoint>& measured,
         double gate, int max_pairs)
      : predicted_(predicted),
        measured_(measured),
        left_(max_pairs),
        candidates_(measured.size()),
        hopeful_(measured.size() + 1, 0),
        taken_(predicted.mean.cols(), false) {
    const int most =
        static_cast<int>(std::min<std::size_t>(measured.size(), predicted.mean.cols()));
    for (int n = 0; n <= most; ++n) {
      gates_.push_back(n == 0 ? 0.0 : chi_square_quantile(gate, n * predicted.dim));
    }
    root_.setZero(most * predicted.dim, most * predicted.dim);
    whitened_.setZero(most * predicted.dim);
    for (std::size_t i = measured.size(); i-- > 0;) {
      std::vector<std::pair<double, int>> order;
      for (int j = 0; j < predicted.mean.cols(); ++j) {
        const double chi_square = predicted.score(measured[i], j).chi_square;
        if (chi_square <= gates_[1]) order.emplace_back(chi_square, j);
      }
      std::sort(order.begin(), order.end());
      for (const auto& [chi_square, j] : order) candidates_[i].push_back(j);
      hopeful_[i] = hopeful_[i + 1] + (order.empty() ? 0 : 1);
    }
  }

  Matching run() {
    current_.column.assign(measured_.size(), -1);
    best_ = current_;
    visit(0, 0);
    return best_;
  }

 private:
  /// Decides about detections from i on, with `pairs` made and jointly compatible.
  void visit(std::size_t i, int pairs) {
    const int reachable = pairs + hopeful_[i];
    if (reachable < best_pairs_ || (reachable == best_pairs_ && current_.cost >= best_.cost))
      return;
    if (i == measured_.size()) {
      best_ = current_;
      best_pairs_ = pairs;
      return;
    }
    const double before = current_.cost;
    for (int j : candidates_[i]) {
      if (taken_[j]) continue;
      if (--left_ < 0) return;
      current_.cost = before + added_chi_square(i, j, pairs);
      if (current_.cost <= gates_[pairs + 1]) {
        current_.column[i] = j;
        taken_[j] = true;
        chosen_.push_back(j);
        visit(i + 1, pairs + 1);
        chosen_.pop_back();
        taken_[j] = false;
      }
    }
    current_.column[i] = -1;
    current_.cost = before;
    visit(i + 1, pairs);
  }

  /// Appends the pair (i, j) to the Cholesky factor of the joint covariance and to the whitened
  /// innovation.
  double added_chi_square(std::size_t i, int j, int pairs) {
    const int dim = predicted_.dim, n = dim * pairs;
    for (int k = 0; k < pairs; ++k) {
      root_.block(n, dim * k, dim, dim) =
          predicted_.covariance.block(dim * j, dim * chosen_[k], dim, dim);
    }
    auto cross = root_.block(n, 0, dim, n);
    if (n > 0) {
      const Eigen::MatrixXd solved = root_.topLeftCorner(n, n).triangularView<Eigen::Lower>().solve(
          Eigen::MatrixXd(cross.transpose()));
      cross = solved.transpose();
    }
    const Eigen::LLT<Eigen::MatrixXd> llt(predicted_.covariance.block(dim * j, dim * j, dim, dim) +
                                          measured_[i].covariance - cross * cross.transpose());
    root_.block(n, n, dim, dim) = llt.matrixL();
    const Eigen::VectorXd innovation =
        predicted_.innovation(measured_[i].z, j) - cross * whitened_.head(n);
    whitened_.segment(n, dim) = llt.matrixL().solve(innovation);
    return whitened_.segment(n, dim).squaredNorm();
  }

  const PredictedSightings& predicted_;
  const std::vector<MeasuredPoint>& measured_;
  int left_;
  std::vector<std::vector<int>> candidates_;  // by detection, nearest first
  std::vector<int> hopeful_;                  // detections from i on that have a candidate
  std::vector<double> gates_;                 // by number of pairs
  std::vector<bool> taken_;                   // by landmark
  std::vector<int> chosen_;                   // landmarks of the pairs made
  Eigen::MatrixXd root_;
  Eigen::VectorXd whitened_;
  Matching current_, best_;
  int best_pairs_ = 0;
};

}  // namespace

Matching joint_compatibility(const PredictedSightings& predicted,
                             const std::vector<MeasuredPoint>& measured, double gate,
                             int max_pairs) {
  if (predicted.mean.cols() == 0 || measured.empty()) {
    return {std::vector<int>(measured.size(), -1), 0.0};
  }
  return Search(predicted, measured, gate, max_pairs).run();
}

}  // namespace hybrid
