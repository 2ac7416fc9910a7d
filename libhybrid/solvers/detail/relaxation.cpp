// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/detail/relaxation.h"

#include <algorithm>
#include <cmath>
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
  if (!planar.empty()) return relax(planar, start);
  const auto spatial = relative_poses<SE3>(factors, IsotropicWeights::kLower);
  if (!spatial.empty()) return relax(spatial, start);
  return {0.0, start};
}

}  // namespace hybrid
