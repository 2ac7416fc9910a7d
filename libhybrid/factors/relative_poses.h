// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libhybrid/core/noise.h"
#include "libhybrid/factors/factor_of.h"

namespace HYBRID_API hybrid {

/// Measurements z_i of poses b_i in the frame of a pose a, with one joint covariance: stacked
/// residuals log(z_i^-1 a^-1 b_i). It is the factor that marginalisation leaves of a part of a pose
/// graph that may move as a whole.
template <class Group>
class RelativePoses : public ContinuousFactor {
 public:
  static constexpr int kDim = Group::kDim;

  /// keys[0] is a; measured[i] is the pose of keys[i + 1] in its frame. Throws Error if the sizes
  /// do not fit or a pose is not finite.
  RelativePoses(const std::vector<Key>& keys, std::vector<Group> measured, const Noise& noise)
      : ContinuousFactor(keys, std::vector<VariableType>(keys.size(), Variable<Group>::type()),
                         kDim * static_cast<int>(measured.size())),
        measured_(std::move(measured)),
        R_(noise.sqrt_information()),
        log_normalizer_(noise.log_normalizer()) {
    if (keys.size() != measured_.size() + 1 || noise.dim() != rows()) {
      throw Error("relative poses whose keys, measurements and noise do not fit");
    }
    for (const Group& z : measured_) check_measurement(*this, z, "pose");
  }

  /// The factor that measures poses[1], poses[2], ... in the frame of poses[0], given the joint
  /// covariance of the tangents of all `poses`.
  static RelativePoses marginal(const std::vector<Key>& keys, const std::vector<Group>& poses,
                                const Eigen::MatrixXd& covariance) {
    std::vector<Group> measured;
    const int rows = kDim * (static_cast<int>(poses.size()) - 1);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, rows + kDim);
    J.rightCols(rows).setIdentity();
    for (std::size_t i = 1; i < poses.size(); ++i) {
      measured.push_back(poses[0].between(poses[i]));
      J.template block<kDim, kDim>(kDim * (i - 1), 0) = -measured.back().inverse().adjoint();
    }
    const Eigen::MatrixXd relative = J * covariance * J.transpose();
    return {keys, std::move(measured), Noise::covariance(0.5 * (relative + relative.transpose()))};
  }

  double cost(const double* const* x) const override {
    return 0.5 * (R_ * residual(x, nullptr)).squaredNorm();
  }
  double linearize(const double* const* x, double* r, double* J) const override {
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(rows(), cols());
    const Eigen::VectorXd e = residual(x, &jacobian);
    Eigen::Map<Eigen::VectorXd>(r, rows()) = R_ * e;
    Eigen::Map<Eigen::MatrixXd>(J, rows(), cols()) = R_ * jacobian;
    return 0.5 * Eigen::Map<Eigen::VectorXd>(r, rows()).squaredNorm();
  }
  double log_normalizer() const override { return log_normalizer_; }
  std::string name() const override { return "relative poses"; }
  using ContinuousFactor::cost;

 private:
  Eigen::VectorXd residual(const double* const* x, Eigen::MatrixXd* J) const {
    Eigen::VectorXd e(rows());
    const Group a = Group::load(x[0]);
    for (std::size_t i = 0; i < measured_.size(); ++i) {
      const Group h = a.between(Group::load(x[i + 1]));
      typename Group::Jacobian Jb;
      const int row = kDim * static_cast<int>(i);
      e.segment<kDim>(row) = measured_[i].between(h).log(J != nullptr ? &Jb : nullptr);
      if (J == nullptr) continue;
      J->block<kDim, kDim>(row, row + kDim) = Jb;
      J->block<kDim, kDim>(row, 0) = -h.times_inverse_adjoint(Jb);
    }
    return e;
  }

  std::vector<Group> measured_;
  Eigen::MatrixXd R_;
  double log_normalizer_;
};

}  // namespace hybrid
