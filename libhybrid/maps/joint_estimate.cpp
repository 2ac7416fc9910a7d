// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/detail/joint_estimate.h"

#include <cmath>

#include "libhybrid/core/error.h"
#include "libhybrid/factors/linear_factor.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/sensor_view.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/marginals/evidence.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

const Key kMotionKey('t', 0);

/// A row of the prior of a map whose landmarks are given in the frame of another one: residual
/// sum R_k (T^-1 y_k - mean_k).
template <class Pose>
class MovedRow : public ContinuousFactor {
 public:
  using Point = typename Pose::Point;
  static constexpr int kDim = Point::RowsAtCompileTime;

  MovedRow(const std::vector<Key>& keys, Eigen::MatrixXd R, std::vector<Point> means)
      : ContinuousFactor(keys, types_of(keys), kDim), R_(std::move(R)), means_(std::move(means)) {}

  double cost(const double* const* x) const override {
    return 0.5 * residual(Variable<Pose>::load(x[0]).inverse(), x).squaredNorm();
  }
  double linearize(const double* const* x, double* r, double* J) const override {
    const Pose T_second_first = Variable<Pose>::load(x[0]).inverse();
    const auto rotation = T_second_first.rotation().matrix();
    Eigen::Map<Eigen::MatrixXd> by(J, kDim, cols());
    by.setZero();
    for (std::size_t k = 0; k < means_.size(); ++k) {
      const auto column = kDim * static_cast<Eigen::Index>(k);
      const Eigen::Matrix<double, kDim, kDim> R = R_.middleCols(column, kDim);
      const Point q = T_second_first * point(x, k);
      by.template leftCols<kDim>() -= R;
      by.template middleCols<Pose::kDim - kDim>(kDim) += R * rotation_derivative(q);
      by.template middleCols<kDim>(Pose::kDim + column) = R * rotation;
    }
    Eigen::Map<Eigen::VectorXd> out(r, kDim);
    out = residual(T_second_first, x);
    return 0.5 * out.squaredNorm();
  }
  double log_normalizer() const override { return Noise::unit(kDim).log_normalizer(); }
  std::string name() const override { return "row of a map"; }

  using ContinuousFactor::cost;

 private:
  static std::vector<VariableType> types_of(const std::vector<Key>& keys) {
    std::vector<VariableType> out(keys.size(), Variable<Point>::type());
    out.front() = Variable<Pose>::type();
    return out;
  }
  Point point(const double* const* x, std::size_t k) const {
    return Variable<Point>::load(x[k + 1]);
  }
  Point residual(const Pose& T_second_first, const double* const* x) const {
    Point out = Point::Zero();
    for (std::size_t k = 0; k < means_.size(); ++k) {
      out += R_.middleCols(kDim * static_cast<Eigen::Index>(k), kDim) *
             (T_second_first * point(x, k) - means_[k]);
    }
    return out;
  }

  Eigen::MatrixXd R_;
  std::vector<Point> means_;
};

/// log of the determinant of the information of a map, halved.
double log_root_of_information(const SparseGaussian& prior) {
  double sum = 0;
  for (const SparseRow& row : prior.rows) {
    sum += std::log(std::abs(row.R.leftCols(prior.dim).determinant()));
  }
  return sum;
}

}  // namespace

template <class Pose>
void JointEstimate<Pose>::add_priors() {
  for (const SparseRow& row : a_.prior.rows) {
    std::vector<LinearFactor::Term> terms;
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(kDim);
    for (std::size_t k = 0; k < row.variables.size(); ++k) {
      const Eigen::MatrixXd R = row.R.middleCols(kDim * static_cast<Eigen::Index>(k), kDim);
      const auto i = static_cast<std::size_t>(row.variables[k]);
      terms.push_back({first(row.variables[k]), R});
      mean += R * a_.landmarks[i].position.template head<kDim>();
    }
    graph_.emplace<LinearFactor>(terms, mean, Noise::unit(kDim));
  }
  for (const SparseRow& row : b_.prior.rows) {
    std::vector<Key> keys{kMotionKey};
    std::vector<Point> means;
    for (const int j : row.variables) {
      keys.push_back(second(j));
      means.push_back(b_.landmarks[static_cast<std::size_t>(j)].position.template head<kDim>());
    }
    graph_.emplace<MovedRow<Pose>>(keys, row.R, means);
  }
}

template <class Pose>
void JointEstimate<Pose>::know(const Pose& T_first_second,
                               const typename Pose::Jacobian& covariance) {
  known_ = std::make_shared<Prior<Pose>>(kMotionKey, T_first_second, Noise::covariance(covariance));
}

template <class Pose>
void JointEstimate<Pose>::estimate(const LandmarkPairs& pairs, const Pose& T_first_second) {
  graph_ = {};
  values_ = {};
  keys_of_b_.clear();
  for (std::size_t j = 0; j < b_.landmarks.size(); ++j) keys_of_b_.emplace_back('b', j);
  for (const auto& [i, j] : pairs) keys_of_b_[static_cast<std::size_t>(j)] = first(i);
  for (std::size_t i = 0; i < a_.landmarks.size(); ++i) {
    values_.insert(first(static_cast<int>(i)),
                   Point(a_.landmarks[i].position.template head<kDim>()));
  }
  for (std::size_t j = 0; j < b_.landmarks.size(); ++j) {
    const Key key = keys_of_b_[j];
    const Point p = b_.landmarks[j].position.template head<kDim>();
    if (!values_.contains(key)) values_.insert(key, Point(T_first_second * p));
  }
  values_.insert(kMotionKey, T_first_second);
  add_priors();
  if (known_) graph_.add(known_);
  const SolverResult solved = levenberg_marquardt(graph_, {values_, {}});
  values_ = solved.values;
  T_ = values_.at<Pose>(kMotionKey);
  chi_square_ = 2 * hybrid::cost(graph_, values_, {});
  marginals_ = std::make_unique<ContinuousMarginals>(graph_, Estimate{values_, {}});
  const Evidence evidence = log_evidence(graph_, {values_, {}});
  if (!evidence.log || !marginals_->valid()) {
    throw Error("the landmarks in common do not determine how the maps lie to each other");
  }
  log_density_ =
      *evidence.log + log_root_of_information(a_.prior) + log_root_of_information(b_.prior);
}

template <class Pose>
typename Pose::Jacobian JointEstimate<Pose>::covariance() const {
  return marginals_->covariance(kMotionKey);
}

template class JointEstimate<SE2>;
template class JointEstimate<SE3>;

}  // namespace hybrid
