// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// An estimated pose and the true one of the same instant.
struct PosePair {
  mrpt::poses::CPose3D estimate;
  mrpt::poses::CPose3D truth;
};

/// Pairs every estimate with the truth nearest in time, if at most `max_difference` seconds away.
/// Other estimates are left out. `truth` must be sorted by time.
std::vector<PosePair> pair_by_time(const Trajectory& estimate, const Trajectory& truth,
                                   double max_difference);

/// Absolute errors of position (m) and of orientation (deg, angle of R_est' R_true).
struct TrajectoryErrors {
  double mean_m = 0, rmse_m = 0, max_m = 0, rotation_mean_deg = 0, rotation_rmse_deg = 0;
};

/// Absolute errors without alignment; NaN when there are no pairs.
TrajectoryErrors trajectory_errors(const std::vector<PosePair>& pairs);

/// The rigid motion T_truth_estimate without scale that minimises the squared distances of the
/// positions (Umeyama 1991). Poses that are all in the plane z = 0 are aligned within the plane.
mrpt::poses::CPose3D alignment(const std::vector<PosePair>& pairs);

/// Mean relative error over all stretches of the true path of one length.
struct RelativeError {
  double distance_m = 0;      ///< length of the stretches
  std::size_t stretches = 0;  ///< starts with at least that length ahead
  double translation_m = 0;   ///< mean error of the relative position; NaN without stretches
  double rotation_deg = 0;    ///< mean error of the relative orientation; NaN without stretches
};

/// Fewer true poses tell nothing of a path.
inline constexpr std::size_t kFewestTruePoses = 3;

/// Errors without and with alignment of the estimate to the truth (a rigid motion), and relative
/// errors over stretches of 1, 10, 100 and 500 m, as far as the path is long enough.
struct TrajectoryReport {
  TrajectoryErrors unaligned, aligned;
  std::vector<RelativeError> relative;
  std::size_t poses = 0;  ///< estimated ones that have a true one
  /// Whether there are so many that the errors tell of the path: fewer fit once aligned.
  bool is_telling() const { return poses >= kFewestTruePoses; }
};

/// Content of a truth file. For positions, rotation errors are NaN and there are no relative
/// errors.
enum class TruthContent { kPoses, kPositions };

/// All errors.
TrajectoryReport trajectory_report(const std::vector<PosePair>& pairs,
                                   TruthContent content = TruthContent::kPoses);

/// Relative pose errors for each distance (m along the true path).
std::vector<RelativeError> relative_errors(const std::vector<PosePair>& pairs,
                                           const std::vector<double>& distances_m);

/// The error of an estimate in its own frame, log(T_estimate^-1 T_truth) = (translation, rotation).
Eigen::Matrix<double, 6, 1> tangent_error(const PosePair& pair);

/// Normalised estimation error squared: mean of e' P^-1 e over poses and degrees of freedom (1 if
/// the covariances are consistent). Covariances, one per pair, are 6x6 over (translation, rotation)
/// or 3x3 over (x, y, yaw), in the frame of the robot. Throws std::invalid_argument on other sizes,
/// or if the numbers of pairs and covariances differ.
double mean_nees(const std::vector<PosePair>& pairs,
                 const std::vector<Eigen::MatrixXd>& covariances);

}  // namespace hybrid
