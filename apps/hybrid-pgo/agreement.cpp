// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-pgo/agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "libhybrid/pose_graph/vertex_id.h"
#include "libhybrid/selection/closure_agreement.h"
#include "mrpt_plugins/health/agreement.h"

namespace hybrid {
namespace {

constexpr double kMostScatter = 2;  // beyond it, the noise itself is bad

/// What residuals of closures may be in units of what their information says.
double scatter_of_closures(const std::vector<NoiseRecord>& noise) {
  for (const NoiseRecord& record : noise) {
    if (record.kind == "closures" && record.measured) {
      return std::clamp(*record.measured, 1.0, kMostScatter);
    }
  }
  return 1;
}

}  // namespace

Health graph_agreement(const Input& input, const Solution& solution, const std::vector<Loop>& loops,
                       const std::vector<NoiseRecord>& noise) {
  if (solution.values.size() > kMostWithCovariances || !input.first_hypotheses.empty()) return {};
  const std::vector<const Loop*> loop_of = loops_of_factors(input, loops);
  RobustProblem problem;
  std::vector<bool> accepted;
  for (std::size_t f = 0; f < input.factors.size(); ++f) {
    const Loop* loop = loop_of[f];
    const bool in_force = loop == nullptr || loop->decision.in_force();
    if (loop != nullptr && !loop->in_map()) {
      problem.closures.push_back(input.factors[f]);
      accepted.push_back(in_force);
    } else if (in_force) {
      problem.trusted.push_back(input.factors[f]);
    }
  }
  if (accepted.empty()) return {};
  const ClosureAgreement found =
      agreement_of_closures(problem, solution.values, accepted, scatter_of_closures(noise));
  std::string rival;
  if (!found.rival_closures.empty()) {
    const std::vector<Key>& keys = problem.closures[found.rival_closures.front()]->keys();
    rival = fmt::format("{} {}", vertex_name(keys[0].index()), vertex_name(keys[1].index()));
  }
  return {closure_agreement_health(found, rival)};
}

}  // namespace hybrid
