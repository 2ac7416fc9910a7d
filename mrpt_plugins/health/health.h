// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// What a quantity says of a result, from what counts least. One that is not judged had no basis.
enum class HealthVerdict { kNotJudged, kGood, kDoubtful, kBad };

/// The value of a quantity in a stretch of the log.
struct HealthSample {
  double time = 0;  ///< when the stretch began [s]
  double value = 0;
  double weight = 0;  ///< on how many comparisons it rests
};

/// One quantity that a run tells about itself, without any truth.
struct HealthEntry {
  std::string name;
  double value = 0;  ///< NaN where it is not judged
  /// Limits that the value is within in a good result; where there is none, infinite.
  double least = 0, most = 0;
  HealthVerdict verdict = HealthVerdict::kGood;
  std::string sentence;  ///< what it means, plain
  std::string knob;      ///< what to look at or to change first; empty where the verdict is good
  /// section.key of the INI, a factor of what "value" is measured in; empty: there is none.
  std::string scale = {};
  std::vector<HealthSample> over_time = {};  ///< empty: it is a value of the whole
  /// Of what not every map of a log has: calibrations, fixes of satellite receivers.
  bool is_optional = false;
};

using Health = std::vector<HealthEntry>;

/// "not judged", "good", "doubtful" or "bad".
const char* to_string(HealthVerdict verdict);

/// The worst verdict of all; good where there is none.
HealthVerdict worst(const Health& health);

/// The limits of a quantity whose large values are bad.
struct UpperLimits {
  double doubtful = 0, bad = 0;
};

/// The verdict about a value with these limits.
HealthVerdict judge(double value, const UpperLimits& limits);

/// An entry about a quantity with these limits; it names the knob where the verdict is not good.
HealthEntry judged_entry(const std::string& name, double value, const UpperLimits& limits,
                         const std::string& sentence, const std::string& knob);

}  // namespace hybrid
