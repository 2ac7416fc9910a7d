// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <optional>
#include <unordered_map>
#include <variant>
#include <vector>

#include "libhybrid/factors/factor.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/selection/prediction.h"

namespace HYBRID_API hybrid {

/// Relative motions of any length by odometry alone, in constant time: the adjoint is a
/// homomorphism, so the covariance of the motion from pose i to pose j is Ad(T_j^-1) (M_j - M_i)
/// Ad(T_j^-1)' with M the running sum of Ad(T_k) Q_k Ad(T_k)', where Q_k is the covariance of step
/// k. Closures have no part in it, so false ones cannot affect it.
class OdometryPath {
 public:
  /// Begins a path at a pose (of type SE2 or SE3; others are ignored). Motions between poses of
  /// different paths are unknown.
  void start(Key pose, VariableType type, const double* x);

  /// Appends a pose to the newest one by a factor between the two; the measured pose is found by
  /// Newton steps from `x`. A pose that cannot be appended starts a path of its own.
  void append(Key from, Key to, const ContinuousFactor& step, VariableType type, const double* x);

  /// Number of poses.
  std::size_t size() const { return index_.size(); }
  /// Removes all poses but the first `size`. Does not throw.
  void shrink(std::size_t size) noexcept;

  /// Prediction of a factor between two poses given the odometry alone; empty unless they are on
  /// one path.
  std::optional<Prediction> innovation(const ContinuousFactor& closure) const;

 private:
  template <class Pose>
  struct Path {
    std::vector<Pose> poses;
    std::vector<typename Pose::Jacobian> spread;  // M
    std::vector<int> part;
  };

  template <class Pose>
  void append_pose(Path<Pose>& path, Key from, Key to, const ContinuousFactor& step,
                   const Pose& start);
  int index(Key pose) const;

  std::variant<std::monostate, Path<SE2>, Path<SE3>> path_;
  std::unordered_map<Key, int> index_;
  int parts_ = 0;
};

}  // namespace hybrid
