// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/factors/between.h"

namespace HYBRID_API hybrid {

/// A measurement that, if it is false, may be a true one of another place.
class MistakablePlace {
 public:
  virtual ~MistakablePlace() = default;
  /// Covariance of the residual of a false one beyond that of a true one, whitened by its noise
  /// (rows x rows).
  virtual const Eigen::MatrixXd& elsewhere() const = 0;
};

/// A relative pose at which surfaces seen from b lie on surfaces seen from a. Where those only look
/// the same, walls lie along walls and floor on floor, too: a false match turns as a true one does,
/// and its position is that of another place.
template <class Pose>
class SurfaceMatch : public Between<Pose>, public MistakablePlace {
 public:
  static constexpr int kSpace = Pose::kDim == SE2::kDim ? 2 : 3;
  using Position = Eigen::Matrix<double, kSpace, 1>;
  using Spread = Eigen::Matrix<double, kSpace, kSpace>;

  /// `spread`: covariance of the way from one place to another that may look the same, in the frame
  /// of b [m^2]. Throws Error for a motion that is not finite.
  SurfaceMatch(Key a, Key b, const Pose& measured, const Noise& noise, const Spread& spread)
      : Between<Pose>(a, b, measured, noise) {
    const auto of_position = this->sqrt_information().template leftCols<kSpace>();
    elsewhere_ = of_position * spread * of_position.transpose();
  }

  const Eigen::MatrixXd& elsewhere() const override { return elsewhere_; }

 private:
  Eigen::MatrixXd elsewhere_;
};

}  // namespace hybrid
