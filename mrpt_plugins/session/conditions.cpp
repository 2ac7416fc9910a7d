// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/conditions.h"

#include <algorithm>
#include <filesystem>

#include "mrpt_plugins/bridge/standard_input.h"

namespace hybrid {
namespace {

/// Whether nothing but noise is corrected.
bool is_of_noise(const LogCorrection& correction) {
  return !correction.hides_ids &&
         std::all_of(correction.lasers.begin(), correction.lasers.end(),
                     [](const auto& laser) { return laser.second.is_as_stated(); }) &&
         std::all_of(correction.sensors.begin(), correction.sensors.end(), [](const auto& sensor) {
           const SensorCorrection& s = sensor.second;
           return !s.mirrored && s.yaw == 0 && s.delay == 0;
         });
}

/// Whether nothing measured is used in place of what the logs state; or nothing but noise.
bool takes_at_word(const ReplaySettings& settings, bool but_for_noise, bool but_for_ids) {
  return std::all_of(settings.robots.begin(), settings.robots.end(), [&](const auto& robot) {
    LogCorrection correction = robot.source.correction;
    if (but_for_ids) correction.hides_ids = false;
    return but_for_noise ? is_of_noise(correction) : correction.is_none();
  });
}

}  // namespace

bool Conditions::allow(const ReplaySettings& settings) const {
  return !corrected || !takes_at_word(settings, aligned, had_no_ids);
}

bool Conditions::want(const Health& health, int signal) const {
  return other == nullptr || (signal == 0 && better(health, *other));
}

bool is_as_stated(const ReplaySettings& settings, bool had_no_ids) {
  return takes_at_word(settings, false, had_no_ids) &&
         std::all_of(settings.robots.begin(), settings.robots.end(), [](const auto& robot) {
           return robot.source.noise == NoiseSource::kMeasured;
         });
}

bool may_measure(const ReplayRequest& request, const ReplaySettings& settings) {
  if (request.stream || request.resume || !settings.map.file.empty()) return false;
  return std::all_of(
      settings.robots.begin(), settings.robots.end(), [](const RobotSettings& robot) {
        std::error_code unknown;
        return robot.source.noise == NoiseSource::kAuto && !is_standard_input(robot.rawlog) &&
               std::filesystem::is_regular_file(robot.rawlog, unknown);
      });
}

}  // namespace hybrid
