// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/geometry/thin_points.h"

#include <cmath>
#include <cstdint>
#include <numeric>
#include <unordered_set>
#include <utility>

namespace hybrid {
namespace {

constexpr double kLeastEdge = 1e-3;  // m
constexpr int kOctave = 8;           // edges from one to its double
constexpr int kEdges = 64 * kOctave;

using Voxel = Eigen::Matrix<std::int64_t, 3, 1>;

struct HashOfVoxel {
  std::size_t operator()(const Voxel& v) const {
    std::uint64_t hash = 0;
    for (Eigen::Index i = 0; i < 3; ++i) {  // splitmix64
      hash += static_cast<std::uint64_t>(v[i]) + 0x9e3779b97f4a7c15U;
      hash = (hash ^ (hash >> 30U)) * 0xbf58476d1ce4e5b9U;
      hash = (hash ^ (hash >> 27U)) * 0x94d049bb133111ebU;
      hash ^= hash >> 31U;
    }
    return static_cast<std::size_t>(hash);
  }
};

/// The first point in each voxel; one more than `most` where there are more.
std::vector<std::size_t> first_points(const Points& points, const Eigen::Vector3d& origin, int edge,
                                      std::size_t most) {
  const double length = kLeastEdge * std::exp2(static_cast<double>(edge) / kOctave);
  std::unordered_set<Voxel, HashOfVoxel> taken;
  taken.reserve(most + 1);
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d place = (points[i] - origin) / length;
    if (!taken.insert(place.array().floor().matrix().cast<std::int64_t>()).second) continue;
    kept.push_back(i);
    if (kept.size() > most) break;
  }
  return kept;
}

}  // namespace

std::vector<std::size_t> thin_points(const Points& points, std::size_t most) {
  if (points.size() <= most) {
    std::vector<std::size_t> all(points.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    return all;
  }
  if (most == 0) return {};
  Eigen::Vector3d origin = points.front();
  for (const Eigen::Vector3d& point : points) origin = origin.cwiseMin(point);
  // At the largest edge, all points are in one voxel.
  std::vector<std::size_t> best{0};
  int too_small = -1, fits = kEdges;
  while (fits - too_small > 1) {
    const int edge = too_small + (fits - too_small) / 2;
    std::vector<std::size_t> kept = first_points(points, origin, edge, most);
    if (kept.size() > most) {
      too_small = edge;
    } else {
      fits = edge;
      best = std::move(kept);
    }
  }
  return best;
}

}  // namespace hybrid
