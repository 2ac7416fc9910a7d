// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/health/closures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hybrid {
namespace {

/// Most closures of a sound front end are true: from half of them on the noise is doubtful, and
/// where nearly all go, it is the noise and not they.
constexpr UpperLimits kRejectedLimits{0.5, 0.9};
constexpr std::size_t kFewestClosures = 5;
constexpr double kNarrow = 3;  // nats: odds of 20 to 1

HealthEntry entry_on_rejected(std::size_t rejected, std::size_t all) {
  return judged_entry("closures rejected", static_cast<double>(rejected) / static_cast<double>(all),
                      kRejectedLimits,
                      fmt::format("{} of {} loop closures were rejected.", rejected, all),
                      "the information of the graph: where noise is stated too small, true "
                      "closures seem false");
}

HealthEntry entry_on_margin(double least) {
  HealthEntry entry;
  entry.name = "least margin of a closure";
  entry.value = least;
  entry.least = kNarrow;
  entry.most = std::numeric_limits<double>::infinity();
  entry.verdict = least < kNarrow ? HealthVerdict::kDoubtful : HealthVerdict::kGood;
  entry.sentence = fmt::format(
      "The closure that was decided most narrowly has log odds of {:.2g} for its decision.", least);
  if (entry.verdict != HealthVerdict::kGood) entry.knob = "loops.csv, column margin";
  return entry;
}

}  // namespace

Health parts_health(const std::vector<ClosureDecision>& links, std::size_t candidates) {
  if (links.empty()) return {};
  const auto unsupported = static_cast<std::size_t>(std::count_if(
      links.begin(), links.end(), [](const ClosureDecision& link) { return !link.accepted(); }));
  HealthEntry entry;
  entry.name = "parts of the trajectory";
  entry.value = static_cast<double>(unsupported);
  entry.sentence =
      unsupported == 0
          ? fmt::format("{} parts of the trajectory are joined by closures that agree.",
                        links.size() + 1)
          : fmt::format(
                "Of {} parts of the trajectory {} are joined by one closure that no other "
                "supports.",
                links.size() + 1, unsupported);
  if (unsupported == 0) return {entry};
  const bool others_would_do = candidates > links.size();
  entry.verdict = others_would_do ? HealthVerdict::kBad : HealthVerdict::kDoubtful;
  entry.knob = "--trusted FILE with pairs that are known to be right";
  return {entry};
}

Health closure_health(const std::vector<ClosureDecision>& decisions) {
  Health health;
  std::size_t judged = 0, rejected = 0;
  double least = std::numeric_limits<double>::infinity();
  for (const ClosureDecision& decision : decisions) {
    if (decision.status == ClosureStatus::kTrusted) continue;
    ++judged;
    rejected += decision.accepted() ? 0 : 1;
    if (decision.checkable && std::isfinite(decision.margin)) {
      least = std::min(least, std::abs(decision.margin));
    }
  }
  if (judged < kFewestClosures) return health;
  health.push_back(entry_on_rejected(rejected, judged));
  if (std::isfinite(least)) health.push_back(entry_on_margin(least));
  return health;
}

}  // namespace hybrid
