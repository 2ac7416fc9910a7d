// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/health/health.h"

#include <algorithm>

namespace hybrid {

const char* to_string(HealthVerdict verdict) {
  switch (verdict) {
    case HealthVerdict::kNotJudged:
      return "not judged";
    case HealthVerdict::kGood:
      return "good";
    case HealthVerdict::kDoubtful:
      return "doubtful";
    case HealthVerdict::kBad:
      return "bad";
  }
  return "unknown";
}

HealthVerdict worst(const Health& health) {
  HealthVerdict out = HealthVerdict::kGood;
  for (const HealthEntry& entry : health) out = std::max(out, entry.verdict);
  return out;
}

HealthVerdict judge(double value, const UpperLimits& limits) {
  if (value > limits.bad) return HealthVerdict::kBad;
  return value > limits.doubtful ? HealthVerdict::kDoubtful : HealthVerdict::kGood;
}

HealthEntry judged_entry(const std::string& name, double value, const UpperLimits& limits,
                         const std::string& sentence, const std::string& knob) {
  const HealthVerdict verdict = judge(value, limits);
  const bool is_good = verdict == HealthVerdict::kGood;
  return {name, value, 0, limits.doubtful, verdict, sentence, is_good ? "" : knob};
}

}  // namespace hybrid
