// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/registration/target_cloud.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstdint>
#include <nanoflann.hpp>

namespace hybrid {
namespace {

constexpr int kLeaf = 8;

/// The cloud as nanoflann reads it.
struct Adaptor {
  const Points* points;
  std::size_t kdtree_get_point_count() const { return points->size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return (*points)[i][axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Index = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Adaptor>,
                                                  Adaptor, 3, std::uint32_t>;

/// A search for the least Mahalanobis distance: a point farther than `best` standard deviations
/// along, the largest of the noise, cannot win.
struct BestMatch {
  using DistanceType = double;  // nanoflann asks for it from version 1.5 on, and for sort()
  void sort() {}

  const Points& points;
  const Points& directions;
  const MatchWeights& weights;
  const Eigen::Vector3d& p;
  double largest_variance;
  int winner;
  double best;

  double worstDist() const { return best * largest_variance; }
  bool full() const { return true; }
  std::size_t size() const { return 1; }
  bool addPoint(double, std::size_t i) {
    const double distance = weights(p - points[i], directions[i]);
    if (distance < best) {
      best = distance;
      winner = static_cast<int>(i);
    }
    return true;
  }
};

Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(const Points& points,
                                                      const std::vector<std::uint32_t>& chosen) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::uint32_t i : chosen) mean += points[i];
  mean /= static_cast<double>(chosen.size());
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (std::uint32_t i : chosen) moments += (points[i] - mean) * (points[i] - mean).transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(moments);
  return solver;
}

}  // namespace

MatchWeights::MatchWeights(const MatchNoise& noise, LocalShape shape) {
  const double across = 1.0 / (noise.across * noise.across);
  const double along = 1.0 / (noise.along * noise.along);
  all = shape == LocalShape::kSurface ? along : across;
  if (shape == LocalShape::kSurface) directed = across - along;
  if (shape == LocalShape::kCurve) directed = along - across;
}

struct TargetCloud::Tree {
  explicit Tree(const Points& points)
      : adaptor{&points}, index(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(kLeaf)) {}
  Adaptor adaptor;
  Index index;
};

TargetCloud::TargetCloud(Points points, LocalShape shape, WorkerPool& pool)
    : points_(std::move(points)),
      directions_(points_.size(), Eigen::Vector3d::Zero()),
      shape_(shape),
      tree_(std::make_unique<Tree>(points_)) {
  if (shape != LocalShape::kPoint) estimate_directions(pool);
}

TargetCloud::~TargetCloud() = default;

std::vector<int> TargetCloud::nearest(const Eigen::Vector3d& p, int k) const {
  std::vector<std::uint32_t> found(k);
  std::vector<double> distances(k);
  const std::size_t count = tree_->index.knnSearch(p.data(), k, found.data(), distances.data());
  return {found.begin(), found.begin() + count};
}

void TargetCloud::estimate_directions(WorkerPool& pool) {
  const int column = shape_ == LocalShape::kSurface ? 0 : 2;  // of the least or largest spread
  const int chunks = (static_cast<int>(size()) + kPointsPerTask - 1) / kPointsPerTask;
  pool.run(chunks, [&](int chunk) {
    std::vector<std::uint32_t> found(kNeighbours);
    std::vector<double> distances(kNeighbours);
    const std::size_t end = std::min(size(), std::size_t(chunk + 1) * kPointsPerTask);
    for (std::size_t i = std::size_t(chunk) * kPointsPerTask; i < end; ++i) {
      found.resize(kNeighbours);
      found.resize(
          tree_->index.knnSearch(points_[i].data(), kNeighbours, found.data(), distances.data()));
      directions_[i] = spread(points_, found).eigenvectors().col(column);
    }
  });
}

int TargetCloud::match(const Eigen::Vector3d& p, const MatchNoise& noise,
                       const MatchWeights& weights, int incumbent, double& distance) const {
  const double largest = std::max(noise.across, noise.along);
  BestMatch search{
      points_, directions_, weights, p, largest * largest, -1, noise.gate * noise.gate};
  if (incumbent >= 0) {
    const double held = weights(p - points_[incumbent], directions_[incumbent]);
    if (held <= search.best) {
      search.best = held;
      search.winner = incumbent;
    }
  }
  tree_->index.findNeighbors(search, p.data(), {});
  distance = search.best;
  return search.winner;
}

}  // namespace hybrid
