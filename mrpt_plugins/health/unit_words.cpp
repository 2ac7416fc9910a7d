// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/health/unit_words.h"

#include <fmt/format.h>

#include <cmath>

namespace hybrid {
namespace {

constexpr double kWheelError = 0.05;  // share: slip, tyres, a wheelbase that is not measured well
constexpr double kSureSigmas = 5;

struct Unit {
  double in_ours;  // so many metres or radians
  const char* name;
};
constexpr Unit kLengths[] = {
    {0.3048, "feet"}, {0.0254, "inches"}, {0.01, "centimetres"}, {0.001, "millimetres"}};
constexpr Unit kAngles[] = {{M_PI / 180, "degrees"}};

/// "; feet?" where a ratio is that of a unit.
template <class Units>
std::string asked(double ratio, const Units& units) {
  for (const Unit& unit : units) {
    if (std::abs(std::abs(std::log(ratio)) + std::log(unit.in_ours)) < kWheelError) {
      return fmt::format(": one of them is in {}?", unit.name);
    }
  }
  return ": one of them has another unit or scale";
}

}  // namespace

std::vector<std::string> unit_words(const std::vector<CalibrationEstimate>& calibration) {
  std::vector<std::string> words;
  for (const CalibrationEstimate& c : calibration) {
    for (const CalibrationEstimate::Entry& e : c.entries) {
      const bool is_length = e.name == "scale of translation";
      if (!e.observed || (!is_length && e.name != "scale of rotation")) continue;
      const double off = std::abs(e.value - 1);
      if (!(e.value > 0) || off <= kWheelError || off <= kSureSigmas * e.sigma) continue;
      const bool is_factor = e.value > 2 || e.value < 0.5;
      words.push_back(fmt::format(
          "{} and odometry differ by {}{}", is_length ? "ranges" : "angles of detections",
          is_factor ? fmt::format("a factor of {:.3g}", e.value > 1 ? e.value : 1 / e.value)
                    : fmt::format("{:.0f} %", 100 * off),
          is_length ? asked(e.value, kLengths) : asked(e.value, kAngles)));
    }
  }
  return words;
}

}  // namespace hybrid
