// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/survey/laser_survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

/// Of scans that differ: of a robot that moves, about so many tenths of a metre of its way.
constexpr std::size_t kMostScans = 600;
/// Two scans differ if so many of the rays that both see have changed by so much [m].
constexpr double kChangedShare = 0.1, kChange = 0.05;
double degrees(double radians) {
  return radians * 180 / M_PI;
}

bool are_alike(const LaserScan& a, const LaserScan& b) {
  if (a.ranges.size() != b.ranges.size()) return false;
  std::size_t seen = 0, changed = 0;
  for (std::size_t i = 0; i < a.ranges.size(); ++i) {
    const double change = std::abs(double(a.ranges[i]) - double(b.ranges[i]));
    if (!std::isfinite(change)) continue;
    ++seen;
    if (change > kChange) ++changed;
  }
  return double(changed) <= kChangedShare * double(seen);
}

double opening_of(const LaserScan& scan) {
  return std::abs(scan.angle_step) * (double(scan.ranges.size()) - 1);
}

void tell(const std::string& label, const LaserScan& scan, const LaserMounting& found,
          std::vector<std::string>& remarks) {
  const std::string name = label.empty() ? "the laser" : "laser " + label;
  const char* changes = "([sensor] noise = stated changes it)";
  const auto say = [&](const std::string& what) {
    remarks.push_back(fmt::format("{}: taken so {}", what, changes));
  };
  if (found.widening != 1) {
    const double stated = degrees(opening_of(scan));
    say(fmt::format("rays of {} fit with a field of view of {:.1f} degrees, not {:.1f}", name,
                    stated * found.widening, stated));
  }
  if (found.mirrored) say(fmt::format("rays of {} fit with the other sense of rotation", name));
  const SE2& T = found.T_robot_stated;
  if (!T.translation().isZero(0)) {
    say(
        fmt::format("{} is {:.2f} +- {:.2f} m farther ahead and {:.2f} +- {:.2f} m farther left "
                    "than the log has it",
                    name, T.x(), found.sigmas.x(), T.y(), found.sigmas.y()));
  }
  if (T.angle() != 0) {
    say(fmt::format("{} is turned by {:.1f} +- {:.1f} degrees beside its stated pose", name,
                    degrees(T.angle()), degrees(found.sigmas.z())));
  }
}

}  // namespace

void LaserSurvey::add(const LogStep& step) {
  for (auto& [label, laser] : lasers_) {
    if (laser.since && step.odometry) {
      laser.since = *laser.since * to_se2(step.odometry->mean);
    } else {
      laser.since.reset();
    }
  }
  DropReport dropped;
  for (const auto& observation : step.observations) {
    const auto known = lasers_.find(observation->sensorLabel);
    if (known != lasers_.end() && known->second.scans.size() >= kMostScans) continue;
    auto scan = scan_in(*observation, options_, dropped);
    if (scan) take(observation->sensorLabel, std::move(*scan));
  }
}

void LaserSurvey::take(const std::string& label, LaserScan scan) {
  Laser& laser = lasers_[label];
  if (!laser.scans.empty()) {
    const LaserScan& last = laser.scans.back().scan;
    if (last.T_robot_sensor.matrix() != scan.T_robot_sensor.matrix()) return;  // another one
    if (are_alike(last, scan)) return;
  }
  laser.scans.push_back({std::move(scan), laser.since});
  laser.since = SE2();
}

void LaserSurvey::conclude(LogFindings& findings) const {
  for (const auto& [label, laser] : lasers_) {
    LaserMounting found = measure_mounting(laser.scans);
    if (options_.field_of_view > 0) found.widening = 1;  // it was given
    if (found.is_as_stated()) continue;
    findings.correction.lasers[label] = found;
    tell(label, laser.scans.front().scan, found, findings.remarks);
  }
}

}  // namespace hybrid
