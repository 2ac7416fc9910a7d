// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/relaxation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "libhybrid/solvers/detail/isotropic_graph.h"
#include "libhybrid/solvers/detail/lifted_descent.h"

namespace hybrid {
namespace {

constexpr double kTightGap = 1e-6;  // relative
constexpr int kLevels = 3;

template <class Pose>
RelaxedPoses relax(const std::vector<IsotropicEdge<Pose>>& graph, const Values& start) {
  const IsotropicForm form = isotropic_form(graph);
  IsotropicMinimum minimum = isotropic_minimum(form, stacked(graph, start));
  RelaxedPoses result;
  climb(form, minimum);
  // Twice the cost of the factors is at least that of the form.
  if (minimum.dual) result.bound = std::max(0.0, 0.5 * minimum.dual->bound);
  result.values = unstacked(graph, rounded(form, minimum.Y), graph.front().from, start);
  return result;
}

/// The edges of each connected part, with its own numbers of poses.
template <class Pose>
std::vector<std::vector<IsotropicEdge<Pose>>> connected_parts(
    const std::vector<IsotropicEdge<Pose>>& graph) {
  std::vector<int> root;  // by number of a pose
  const auto find = [&](int i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const IsotropicEdge<Pose>& edge : graph) {
    while (static_cast<int>(root.size()) <= std::max(edge.i, edge.j)) root.push_back(root.size());
    root[find(edge.j)] = find(edge.i);
  }
  std::map<int, std::vector<IsotropicEdge<Pose>>> parts;  // by root
  std::vector<int> number(root.size(), -1);
  std::map<int, int> poses;  // of each part
  for (IsotropicEdge<Pose> edge : graph) {
    const int part = find(edge.i);
    for (int* pose : {&edge.i, &edge.j}) {
      if (number[*pose] < 0) number[*pose] = poses[part]++;
      *pose = number[*pose];
    }
    parts[part].push_back(edge);
  }
  std::vector<std::vector<IsotropicEdge<Pose>>> all;
  for (auto& [part, edges] : parts) all.push_back(std::move(edges));
  return all;
}

/// The sum of the bounds of the connected parts, which are independent of each other.
template <class Pose>
RelaxedPoses relax_parts(const std::vector<IsotropicEdge<Pose>>& graph, const Values& start) {
  RelaxedPoses result{0.0, start};
  for (const auto& part : connected_parts(graph)) {
    RelaxedPoses relaxed = relax(part, result.values);
    relaxed.bound += result.bound;
    result = std::move(relaxed);
  }
  return result;
}

}  // namespace

IsotropicMinimum isotropic_minimum(const IsotropicForm& form, const Eigen::MatrixXd& start) {
  IsotropicMinimum minimum{nearest_minimum(form, start), {}};
  const double cost = hybrid::cost(form, minimum.Y);
  if (!std::isfinite(cost)) return minimum;
  // The zero eigenvalues are known up to rounding, and the gap allows a tolerance.
  const double rounding = 1e-11 * form.M.diagonal().maxCoeff() * form.unknowns();
  minimum.dual = dual_bound(form, minimum.Y, std::max(rounding, kTightGap * cost));
  if (minimum.dual && minimum.dual->gap <= rounding) minimum.dual->gap = 0.0;
  return minimum;
}

int climb(const IsotropicForm& form, IsotropicMinimum& minimum) {
  int level = 0;
  for (; level < kLevels && minimum.dual && !minimum.dual->tight; ++level) {
    IsotropicMinimum next =
        isotropic_minimum(form, lifted(form, minimum.Y, minimum.dual->direction));
    if (!next.dual) break;
    minimum = std::move(next);
  }
  return level;
}

RelaxedPoses relax_poses(const std::vector<ContinuousFactorPtr>& factors, const Values& start) {
  const auto planar = relative_poses<SE2>(factors, IsotropicWeights::kLower);
  if (!planar.empty()) return relax_parts(planar, start);
  const auto spatial = relative_poses<SE3>(factors, IsotropicWeights::kLower);
  if (!spatial.empty()) return relax_parts(spatial, start);
  return {0.0, start};
}

}  // namespace hybrid
