// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-pgo/fixed.h"

#include <fmt/format.h>

#include "libhybrid/core/chi_square.h"

namespace hybrid {
namespace {

/// Some may be false, not most of them.
constexpr UpperLimits kContradictLimits{0.3, 0.5};
constexpr double kFit = 0.999;       // of measurements that agree
constexpr double kMostVariance = 4;  // to the stated one: more is a matter of what is measured

}  // namespace

Health fixed_health(const Input& input, const std::vector<Loop>& loops) {
  if (input.graph.fixed.empty()) return {};
  std::size_t all = 0, contradict = 0;
  for (const Loop& loop : loops) {
    if (!loop.in_map()) continue;
    ++all;
    const double most =
        kMostVariance * chi_square_quantile(kFit, input.factors[loop.factor]->rows());
    contradict += !loop.decision.in_force() || loop.decision.chi_square > most ? 1 : 0;
  }
  if (all == 0) return {};
  return {judged_entry(
      "fixed vertices against the map", static_cast<double>(contradict) / static_cast<double>(all),
      kContradictLimits,
      fmt::format("{} of {} poses and positions measured in the map contradict the fixed vertices.",
                  contradict, all),
      "the VERTEX lines of vertices with a FIX line, at which they stand: are they in the frame of "
      "the map?")};
}

}  // namespace hybrid
