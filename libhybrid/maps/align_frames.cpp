// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/align_frames.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/factors/sensor_view.h"

namespace hybrid {
namespace {

template <int kDim>
class FrameAligner {
 public:
  using Point = Eigen::Matrix<double, kDim, 1>;
  using Points = Eigen::Matrix<double, kDim, Eigen::Dynamic>;
  using Motion = Eigen::Transform<double, kDim, Eigen::Isometry>;

  explicit FrameAligner(const std::vector<CommonPoint>& points)
      : a_(kDim, points.size()), b_(kDim, points.size()) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      a_.col(static_cast<Eigen::Index>(i)) = points[i].first.head<kDim>();
      b_.col(static_cast<Eigen::Index>(i)) = points[i].second.head<kDim>();
    }
  }

  std::optional<AlignedFrames> run(double odds) {
    if (a_.cols() <= kDim) return std::nullopt;
    find_least_median();
    std::vector<int> agreeing;
    for (int round = 0; round < kRounds; ++round) {
      agreeing = that_agree();
      if (agreeing.size() <= kDim) return std::nullopt;
      T_ = motion(agreeing);
    }
    AlignedFrames out;
    out.sigma = sigma();
    out.agreeing = agreeing.size();
    out.log_odds = log_odds(agreeing, out.sigma);
    if (!(out.log_odds >= std::log(odds))) return std::nullopt;
    out.covariance = covariance(agreeing, out.sigma);
    constexpr int kTurn = kDim == 2 ? 1 : 3;
    const double turn = out.covariance.diagonal().tail(kTurn).maxCoeff();
    if (!(turn < kDeterminedTurn * kDeterminedTurn)) return std::nullopt;
    out.T_first_second.linear().template topLeftCorner<kDim, kDim>() = T_.linear();
    out.T_first_second.translation().template head<kDim>() = T_.translation();
    return out;
  }

 private:
  static constexpr int kSamples = 2000;           // of as few points as determine a motion
  static constexpr int kRounds = 5;               // of choosing what agrees and aligning that
  static constexpr double kGate = 0.9999;         // chi-square probability of a point that agrees
  static constexpr double kLeastSigma = 1e-4;     // [m]
  static constexpr double kDeterminedTurn = 0.5;  // standard deviation [rad]

  template <class Indices>
  Motion motion(const Indices& indices) const {
    return Motion(Eigen::umeyama(b_(Eigen::all, indices), a_(Eigen::all, indices), false));
  }

  Eigen::VectorXd squared_distances(const Motion& T) const {
    return ((T.linear() * b_).colwise() + T.translation() - a_).colwise().squaredNorm();
  }

  static double median(Eigen::VectorXd values) {
    const auto middle = values.begin() + values.size() / 2;
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  }

  void find_least_median() {
    std::mt19937_64 random;
    const auto n = static_cast<std::uint64_t>(a_.cols());
    double least = 0;
    for (int k = 0; k < kSamples; ++k) {
      std::array<int, kDim> sample;
      for (int& i : sample) i = static_cast<int>(random() % n);
      const Motion T = motion(sample);
      const double m = median(squared_distances(T));
      if (k > 0 && !(m < least)) continue;
      least = m;
      T_ = T;
    }
  }

  /// Of the differences, from their median, which outliers do not move.
  double sigma() const {
    const double m = median(squared_distances(T_));
    return std::max(kLeastSigma, std::sqrt(m / chi_square_quantile(0.5, kDim)));
  }

  std::vector<int> that_agree() const {
    const double s = sigma();
    const double limit = s * s * chi_square_quantile(kGate, kDim);
    const Eigen::VectorXd d = squared_distances(T_);
    std::vector<int> out;
    for (int i = 0; i < d.size(); ++i) {
      if (d[i] <= limit) out.push_back(i);
    }
    return out;
  }

  /// How many points are farther from each other than two sigmas: a greedy choice.
  int apart(const std::vector<int>& indices, double sigma) const {
    std::vector<int> chosen;
    for (const int i : indices) {
      const bool near = std::any_of(chosen.begin(), chosen.end(), [&](int j) {
        return (a_.col(i) - a_.col(j)).norm() < 2 * sigma;
      });
      if (!near) chosen.push_back(i);
    }
    return static_cast<int>(chosen.size());
  }

  double log_odds(const std::vector<int>& indices, double sigma) const {
    const Points p = a_(Eigen::all, indices);
    const Points centred = p.colwise() - p.rowwise().mean();
    const Eigen::Matrix<double, kDim, kDim> scatter =
        centred * centred.transpose() / static_cast<double>(indices.size());
    const double gain = 0.5 * (std::log(scatter.determinant()) - 2 * kDim * std::log(sigma));
    return (apart(indices, sigma) - kDim) * gain;
  }

  Eigen::MatrixXd covariance(const std::vector<int>& indices, double sigma) const {
    constexpr int kMotion = kDim == 2 ? 3 : 6;
    Eigen::Matrix<double, kMotion, kMotion> information;
    information.setZero();
    for (const int i : indices) {
      Eigen::Matrix<double, kDim, kMotion> J;
      J.template leftCols<kDim>().setIdentity();
      J.template rightCols<kMotion - kDim>() = -rotation_derivative(Point(b_.col(i)));
      information += J.transpose() * J / (sigma * sigma);
    }
    return information.inverse() * static_cast<double>(indices.size());
  }

  Points a_, b_;
  Motion T_ = Motion::Identity();
};

}  // namespace

std::optional<AlignedFrames> align_frames(const std::vector<CommonPoint>& points, bool is_3d,
                                          double odds) {
  return is_3d ? FrameAligner<3>(points).run(odds) : FrameAligner<2>(points).run(odds);
}

}  // namespace hybrid
