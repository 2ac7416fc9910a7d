// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libhybrid/geometry/points.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/registration/observability.h"
#include "libhybrid/registration/target_cloud.h"

namespace HYBRID_API hybrid {

/// The residual of a match between a source and a target point.
enum class MatchMetric {
  kSurface,  ///< distance to the surface of the target, or to its curve in a plane scan
  kPoint     ///< distance to the point
};

struct RegistrationOptions {
  SE3 start;  ///< of T_target_source
  MatchMetric metric = MatchMetric::kSurface;
  double gate = 3.0;  ///< see MatchNoise::gate
  /// If fewer than this share of the source points find a counterpart from `start`, as with partial
  /// overlap, other starts are tried too, and the lowest objective wins. 0: never.
  double convincing_share = 0.8;
  int threads = 0;  ///< 0: one per core, at most 4; the result is the same for any number
};

/// The record of the alternation at one covariance; half-steps alternate, discrete first.
struct RegistrationStage {
  std::size_t source_points = 0, target_points = 0;
  MatchNoise noise;
  std::vector<double> objectives;  ///< after each half-step; never rising (eq. 10)
  int inliers = 0;
};

struct RegistrationResult {
  enum class Status {
    kConverged,
    kUnobservable,  ///< the matches leave some motions free, see `free_motions`
    kNoMatch        ///< fewer than three points found a counterpart
  };

  Status status = Status::kConverged;
  SE3 T_target_source;
  /// Laplace approximation (eq. 14) in the tangent of T_target_source; zero unless all motions are
  /// observable.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::vector<FreeMotion> free_motions;
  LocalShape shape = LocalShape::kSurface;
  MatchNoise noise;             ///< of the last stage; `across` is estimated from the matches
  std::vector<int> assignment;  ///< by source point: its counterpart in the target, -1 for none
  int inliers = 0;
  double rms = 0.0;                       ///< distance between matched points, root mean square
  double rms_across = 0.0;                ///< its part across the surface or curve
  double objective = 0.0;                 ///< of the last stage, see Alignment::match
  int iterations = 0;                     ///< pairs of half-steps from the best start
  int starts = 1;                         ///< number of starts that were tried
  std::vector<RegistrationStage> stages;  ///< of the best start
  double seconds = 0.0;
};

/// Registers `source` to `target`: alternates exact matching and pose estimation, with a covariance
/// that shrinks while the clouds become denser, and at last with the noise estimated from the
/// matches. Throws Error for clouds of fewer than three points, with one that is not finite, or of
/// points that coincide.
RegistrationResult register_clouds(const Points& source, const Points& target,
                                   const RegistrationOptions& options = {});

}  // namespace hybrid
