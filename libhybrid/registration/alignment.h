// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <vector>

#include "libhybrid/geometry/se3.h"
#include "libhybrid/registration/target_cloud.h"

namespace HYBRID_API hybrid {

/// Point-cloud registration as a hybrid problem (Fig. 1c of the paper): one continuous variable,
/// T_target_source, and one discrete variable per source point, its counterpart in the target or
/// the outlier state. Holds the assignment; the target must outlive it.
class Alignment {
 public:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  Alignment(Points source, const TargetCloud& target, const MatchNoise& noise, WorkerPool& pool);

  /// Changes the noise; keeps the assignment as incumbent.
  void set_noise(const MatchNoise& noise);
  const MatchNoise& noise() const { return noise_; }
  LocalShape shape() const { return target_->shape(); }

  /// The discrete half-step (eq. 8a), exact: returns the objective, the sum of half the squared
  /// Mahalanobis distances with gate^2 / 2 for each outlier. The joint negative log posterior of
  /// eq. 6 is this plus a constant.
  double match(const SE3& T_target_source);

  /// The continuous half-step (eq. 8b): damped Gauss-Newton steps on the pairs, each accepted only
  /// if it lowers the objective, which it returns.
  double align(SE3& T_target_source, int max_steps);

  std::size_t size() const { return source_.size(); }
  /// By source point: index of its counterpart, -1 for the outlier state.
  const std::vector<int>& assignment() const { return assignment_; }
  int changes() const { return changes_; }  ///< discrete variables that the last match() changed
  int inliers() const { return inliers_; }

  /// Information of the pairs about a motion of the source, (translation, rotation vector about
  /// `pivot`) in axes of the target, and its gradient.
  struct System {
    Matrix6 H = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
  };
  System system(const SE3& T_target_source, const MatchWeights& weights,
                const Eigen::Vector3d& pivot) const;

  /// Root mean square distances of the pairs: across the surface or curve of the target (per axis
  /// for LocalShape::kPoint), and in all directions.
  struct Residuals {
    double across = 0.0;
    double all = 0.0;
  };
  Residuals residuals(const SE3& T_target_source) const;

  /// Standard deviation across surface or curve, robustly from the median distance of the pairs; 0
  /// without pairs.
  double noise_across(const SE3& T_target_source) const;

  /// Approximate root mean square motion of the source points between two poses.
  double motion(const SE3& from, const SE3& to) const;

 private:
  template <class Sum, class Visit>
  Sum sum_over_pairs(const SE3& T_target_source, const Visit& visit) const;
  double objective(const SE3& T_target_source) const;

  Points source_;
  const TargetCloud* target_;
  MatchNoise noise_;
  WorkerPool* pool_;
  Eigen::Vector3d center_;  // of the source, in its frame
  double radius_;           // of the source
  std::vector<int> assignment_;
  int changes_ = 0;
  int inliers_ = 0;
};

/// The pose after a motion (translation, rotation vector about `pivot`) in axes of the target.
SE3 moved(const SE3& T_target_source, const Alignment::Vector6& motion,
          const Eigen::Vector3d& pivot);

}  // namespace hybrid
