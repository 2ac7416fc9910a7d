// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Edges of a graph that are not what they seem.
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "libhybrid/pose_graph/pose_graph.h"

namespace hybrid {
namespace {

template <class T>
bool same(const GraphEdge<T>& a, const GraphEdge<T>& b) {
  std::array<double, Variable<T>::kSize> x{}, y{};
  Variable<T>::store(a.measured, x.data());
  Variable<T>::store(b.measured, y.data());
  return x == y && a.noise.sqrt_information() == b.noise.sqrt_information();
}

template <class T>
std::size_t erase_copies(std::vector<GraphEdge<T>>& edges) {
  std::map<std::pair<Key, Key>, std::vector<std::size_t>> between;  // edges that stay
  std::size_t kept = 0;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    std::vector<std::size_t>& others = between[{edges[e].from, edges[e].to}];
    bool is_copy = false;
    for (const std::size_t other : others) is_copy = is_copy || same(edges[other], edges[e]);
    if (is_copy) continue;
    others.push_back(kept);
    if (kept != e) edges[kept] = edges[e];
    ++kept;
  }
  const std::size_t erased = edges.size() - kept;
  edges.erase(edges.begin() + static_cast<std::ptrdiff_t>(kept), edges.end());
  return erased;
}

/// Counts the edges that would say something if their information were a covariance, and do not as
/// it is.
template <class Pose>
std::size_t count_inverted(const std::vector<GraphEdge<Pose>>& edges) {
  constexpr int kPoint = Pose::Point::RowsAtCompileTime;
  std::size_t count = 0;
  for (const GraphEdge<Pose>& edge : edges) {
    const auto says_little = [&](const Eigen::MatrixXd& covariance) {
      const Eigen::VectorXd sigmas = covariance.diagonal().cwiseSqrt();
      return sigmas.tail(Pose::kDim - kPoint).minCoeff() > M_PI &&
             sigmas.head(kPoint).minCoeff() > edge.measured.translation().norm();
    };
    if (says_little(edge.noise.covariance()) && !says_little(edge.noise.information())) ++count;
  }
  return count;
}

}  // namespace

void erase_copies(PoseGraph& graph) {
  if (graph.alternatives_count() > 0) return;
  graph.copies += erase_copies(graph.poses2) + erase_copies(graph.poses3) +
                  erase_copies(graph.points2) + erase_copies(graph.points3);
}

bool is_information_inverted(const PoseGraph& graph) {
  const std::size_t all = graph.poses2.size() + graph.poses3.size();
  return 2 * (count_inverted(graph.poses2) + count_inverted(graph.poses3)) > all;
}

}  // namespace hybrid
