// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/health/unit_words.h"

#include <fmt/format.h>

#include <cmath>

#include "mrpt_plugins/input/units.h"

namespace hybrid {
namespace {

constexpr double kWheelError = 0.05;  // share: slip, tyres, a wheelbase that is not measured well
constexpr double kSureSigmas = 5;

std::string asked(const std::string& unit) {
  return unit.empty() ? ": one of them has another unit or scale"
                      : fmt::format(": one of them is in {}?", unit);
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
          asked(is_length ? length_unit(e.value) : angle_unit(e.value))));
    }
  }
  return words;
}

}  // namespace hybrid
