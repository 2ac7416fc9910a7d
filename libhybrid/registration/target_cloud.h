// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "libhybrid/core/worker_pool.h"
#include "libhybrid/geometry/points.h"

namespace HYBRID_API hybrid {

/// Points per task: fixed, so that sums do not depend on the number of threads.
inline constexpr int kPointsPerTask = 1024;

/// The local shape of the target around a point, on which a matched point may be.
enum class LocalShape {
  kPoint,    ///< the point itself, with the same noise in all directions
  kSurface,  ///< a piece of surface: the direction is its normal
  kCurve     ///< a piece of curve, as in plane scans: the direction is its tangent
};

/// Noise of a matched pair T p - q, in the unit of the clouds: across the surface or curve, and
/// along it, in the order of the spacing of points. Beyond `gate` standard deviations a pair is
/// less likely than the outlier state, whose density is constant.
struct MatchNoise {
  double across = 1.0;
  double along = 1.0;
  double gate = 3.0;
};

/// The squared Mahalanobis distance of a pair, all |r|^2 + directed (direction . r)^2.
struct MatchWeights {
  double all = 1.0;
  double directed = 0.0;

  MatchWeights(const MatchNoise& noise, LocalShape shape);
  double operator()(const Eigen::Vector3d& r, const Eigen::Vector3d& direction) const {
    const double d = direction.dot(r);
    return all * r.squaredNorm() + directed * d * d;
  }
};

/// The target of a registration: its points, the local direction of each, and a kd-tree.
class TargetCloud {
 public:
  /// Directions of a surface or curve come from the `kNeighbours` nearest points of each.
  TargetCloud(Points points, LocalShape shape, WorkerPool& pool);
  ~TargetCloud();

  static constexpr int kNeighbours = 12;

  std::size_t size() const { return points_.size(); }
  LocalShape shape() const { return shape_; }
  const Points& points() const { return points_; }
  const Eigen::Vector3d& point(int i) const { return points_[i]; }
  /// Unit vector; zero for LocalShape::kPoint.
  const Eigen::Vector3d& direction(int i) const { return directions_[i]; }

  /// The k nearest points to `p`, nearest first; fewer if the cloud is smaller.
  std::vector<int> nearest(const Eigen::Vector3d& p, int k) const;

  /// The exact discrete half-step for one point (eq. 8a): the target point of least squared
  /// Mahalanobis distance from `p`, or -1 for the outlier state if that is likelier. Ties keep the
  /// `incumbent`. `distance` receives the squared distance, gate^2 for an outlier.
  int match(const Eigen::Vector3d& p, const MatchNoise& noise, const MatchWeights& weights,
            int incumbent, double& distance) const;

 private:
  struct Tree;

  void estimate_directions(WorkerPool& pool);

  Points points_;
  Points directions_;
  LocalShape shape_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace hybrid
