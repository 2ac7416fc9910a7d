// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "mrpt_plugins/health/health_lines.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

namespace hybrid {
namespace {

/// What the value of a good result is.
std::string limits_of(const HealthEntry& entry) {
  if (!std::isfinite(entry.least)) return fmt::format("at most {:.3g}", entry.most);
  if (!std::isfinite(entry.most)) return fmt::format("at least {:.3g}", entry.least);
  return fmt::format("{:.3g} to {:.3g}", entry.least, entry.most);
}

}  // namespace

std::vector<std::string> health_lines(const Health& health) {
  std::vector<std::string> lines, doubtful;
  for (const HealthEntry& entry : health) {
    if (entry.verdict == HealthVerdict::kBad) {
      lines.push_back(
          fmt::format("warning: {}: {} Look at: {}", entry.name, entry.sentence, entry.knob));
    } else if (entry.verdict == HealthVerdict::kDoubtful) {
      doubtful.push_back(
          fmt::format("{} is {:.3g} (good: {})", entry.name, entry.value, limits_of(entry)));
    }
  }
  if (!doubtful.empty()) lines.push_back(fmt::format("doubtful: {}", fmt::join(doubtful, ", ")));
  return lines;
}

}  // namespace hybrid
