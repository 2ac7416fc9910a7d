// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/detail/agreeing_pairs.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/factors/sensor_view.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/maps/place_map.h"

namespace hybrid {
namespace {

constexpr int kMostSteps = 20;            // of Gauss and Newton
constexpr double kMostByChance = 0.9999;  // probability of what is not left out

/// Joint covariance of some landmarks of a map.
template <class Pose>
Eigen::MatrixXd joint_covariance_of(const MapRecord& map, const std::vector<int>& landmarks) {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  const PlaceMap<Pose> places(map, landmarks);
  const auto n = static_cast<Eigen::Index>(landmarks.size());
  Eigen::MatrixXd out(kDim * n, kDim * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::MatrixXd columns = places.columns_of(static_cast<int>(i));
    for (Eigen::Index j = 0; j < n; ++j) {
      out.template block<kDim, kDim>(kDim * j, kDim * i) =
          columns.template middleRows<kDim>(kDim * landmarks[static_cast<std::size_t>(j)]);
    }
  }
  return out;
}

/// The differences of pairs, and how well they are known.
template <class Pose>
class PairTest {
 public:
  static constexpr int kDim = Pose::Point::RowsAtCompileTime;

  PairTest(const MapRecord& first, const MapRecord& second, LandmarkPairs pairs, const Pose& T)
      : first_(first), second_(second), pairs_(std::move(pairs)), T_(T) {
    std::vector<int> of_first, of_second;
    for (const auto& [i, j] : pairs_) {
      of_first.push_back(i);
      of_second.push_back(j);
    }
    Ca_ = joint_covariance_of<Pose>(first, of_first);
    Cb_ = joint_covariance_of<Pose>(second, of_second);
  }

  LandmarkPairs run() {
    while (pairs_.size() > kDim + 2) {
      solve();
      const auto [worst, excess] = worst_pair();
      if (excess <= chi_square_quantile(kMostByChance, kDim)) break;
      leave_out(worst);
    }
    return pairs_;
  }

 private:
  Eigen::Index size() const { return kDim * static_cast<Eigen::Index>(pairs_.size()); }

  /// Least squares of the motion; forces are what holds the pairs together, P their covariance.
  void solve() {
    for (int step = 0; step < kMostSteps; ++step) {
      const auto R = T_.rotation().matrix();
      Eigen::VectorXd off(size());
      Eigen::MatrixXd J(size(), Pose::kDim), turn = Eigen::MatrixXd::Zero(size(), size());
      for (std::size_t k = 0; k < pairs_.size(); ++k) {
        const Eigen::Index at = kDim * static_cast<Eigen::Index>(k);
        const typename Pose::Point a = place(first_, pairs_[k].first),
                                   b = place(second_, pairs_[k].second);
        off.segment<kDim>(at) = a - T_ * b;
        J.template block<kDim, kDim>(at, 0) = R;
        J.template block<kDim, Pose::kDim - kDim>(at, kDim) = -R * rotation_derivative(b);
        turn.template block<kDim, kDim>(at, at) = R;
      }
      const Eigen::LDLT<Eigen::MatrixXd> S(Ca_ + turn * Cb_ * turn.transpose());
      const Eigen::MatrixXd SJ = S.solve(J);
      const Eigen::LDLT<Eigen::MatrixXd> information(J.transpose() * SJ);
      const typename Pose::Tangent move = information.solve(SJ.transpose() * off);
      T_ = T_ * Pose::exp(move);
      P_ = S.solve(Eigen::MatrixXd::Identity(size(), size())) -
           SJ * information.solve(SJ.transpose());
      forces_ = Eigen::VectorXd(P_ * off);
      chi_square_ = off.dot(forces_);
      if (move.norm() < 1e-9) break;
    }
  }

  /// The pair without which chi-square falls most, by the variance factor of the others.
  std::pair<std::size_t, double> worst_pair() const {
    std::pair<std::size_t, double> worst{0, 0};
    const double freedom = static_cast<double>(size()) - Pose::kDim - kDim;
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const Eigen::Index at = kDim * static_cast<Eigen::Index>(k);
      const Eigen::Matrix<double, kDim, 1> force = forces_.segment<kDim>(at);
      const Eigen::Matrix<double, kDim, kDim> P = P_.template block<kDim, kDim>(at, at);
      const double fall = force.dot(P.ldlt().solve(force));
      const double excess = fall / std::max(1.0, (chi_square_ - fall) / freedom);
      if (excess > worst.second) worst = {k, excess};
    }
    return worst;
  }

  void leave_out(std::size_t pair) {
    pairs_.erase(pairs_.begin() + static_cast<std::ptrdiff_t>(pair));
    std::vector<Eigen::Index> rows;
    for (Eigen::Index row = 0; row < Ca_.rows(); ++row) {
      if (row / kDim != static_cast<Eigen::Index>(pair)) rows.push_back(row);
    }
    Ca_ = Ca_(rows, rows).eval();
    Cb_ = Cb_(rows, rows).eval();
  }

  static typename Pose::Point place(const MapRecord& map, int landmark) {
    return map.landmarks[static_cast<std::size_t>(landmark)].position.template head<kDim>();
  }

  const MapRecord &first_, &second_;
  LandmarkPairs pairs_;
  Pose T_;
  Eigen::MatrixXd Ca_, Cb_, P_;
  Eigen::VectorXd forces_;
  double chi_square_ = 0;
};

}  // namespace

template <class Pose>
LandmarkPairs agreeing_pairs(const MapRecord& first, const MapRecord& second, LandmarkPairs pairs,
                             Pose T) {
  return PairTest<Pose>(first, second, std::move(pairs), T).run();
}

template LandmarkPairs agreeing_pairs(const MapRecord&, const MapRecord&, LandmarkPairs, SE2);
template LandmarkPairs agreeing_pairs(const MapRecord&, const MapRecord&, LandmarkPairs, SE3);

}  // namespace hybrid
