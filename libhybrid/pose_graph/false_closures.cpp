// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/pose_graph/false_closures.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "libhybrid/core/sort_unique.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace hybrid {
namespace {

constexpr double kSide = 10.0;  // of the cube of translations [m]

/// Uniform in [low, high): standard distributions differ between libraries, the engine does not.
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  std::size_t below(std::size_t bound) {
    return std::min(bound - 1, static_cast<std::size_t>((*this)(0.0, double(bound))));
  }

 private:
  std::mt19937_64 engine_;
};

SE2 random_pose(Uniform& uniform, const SE2&) {
  const double x = uniform(-0.5 * kSide, 0.5 * kSide);
  const double y = uniform(-0.5 * kSide, 0.5 * kSide);
  return {x, y, uniform(-M_PI, M_PI)};
}

SE3 random_pose(Uniform& uniform, const SE3&) {
  Eigen::Vector3d t;
  for (double& entry : t) entry = uniform(-0.5 * kSide, 0.5 * kSide);
  // Shoemake's uniform unit quaternion.
  const double u = uniform(0.0, 1.0);
  const double a = uniform(0.0, 2.0 * M_PI);
  const double b = uniform(0.0, 2.0 * M_PI);
  const Eigen::Quaterniond q(std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a),
                             std::sqrt(1 - u) * std::cos(a), std::sqrt(u) * std::sin(b));
  return {t, q};
}

template <class Pose>
void add(std::vector<GraphEdge<Pose>>& edges, const OdometryEdges& is_odometry, double rate,
         std::uint64_t seed) {
  std::vector<Key> poses;
  std::vector<std::size_t> closures;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    poses.push_back(edges[e].from);
    poses.push_back(edges[e].to);
    if (!is_odometry(edges[e].from, edges[e].to)) closures.push_back(e);
  }
  sort_unique(poses);
  const auto count = static_cast<std::size_t>(std::lround(closures.size() * rate / (1.0 - rate)));
  if (count == 0) return;
  if (poses.size() < 3) throw Error("false closures need a graph of at least three poses");
  Uniform uniform(seed);
  for (std::size_t k = 0; k < count;) {
    const std::size_t a = uniform.below(poses.size());
    const std::size_t b = uniform.below(poses.size());
    if (a == b || a + 1 == b || b + 1 == a) continue;
    const Noise noise = edges[closures[uniform.below(closures.size())]].noise;
    edges.push_back({poses[a], poses[b], random_pose(uniform, Pose()), noise});
    ++k;
  }
}

}  // namespace

PoseGraph add_false_closures(const PoseGraph& graph, double rate, std::uint64_t seed) {
  if (!(rate >= 0.0) || !(rate < 1.0)) {
    throw Error("the share of false closures must be in [0, 1), got " + std::to_string(rate));
  }
  PoseGraph corrupted = graph;
  const OdometryEdges is_odometry(graph);
  add(corrupted.poses2, is_odometry, rate, seed);
  add(corrupted.poses3, is_odometry, rate, seed);
  return corrupted;
}

}  // namespace hybrid
