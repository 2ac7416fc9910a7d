// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/mrpt_plugins/input/log_files.h"
#include "tests/support/scan_worlds.h"

namespace hybrid {

using mrpt::obs::CObservation2DRangeScan;

/// A drive with a laser, and what of its log is not as it should be.
struct ScanLog {
  std::vector<SE2> way = testing::way_around_ring(1, 0.1);
  testing::FloorPlan plan = testing::ring();
  bool has_odometry = true;
  /// What is wrong with scan number i.
  std::function<void(std::size_t, CObservation2DRangeScan&)> spoil = [](auto, auto&) {};
  std::function<double(std::size_t)> time = [](std::size_t i) { return 1e9 + 0.2 * double(i); };
  /// The motion that odometry tells, of the true one to scan number i.
  std::function<SE2(std::size_t, const SE2&)> odometry = [](auto, const SE2& motion) {
    return motion;
  };
  /// Whether the motion to scan number i is not in the log.
  std::function<bool(std::size_t)> is_missing = [](auto) { return false; };
};

/// Writes it as actions and frames, or frames alone.
inline void write_scan_log(const std::string& path, const ScanLog& log) {
  Objects objects;
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  for (std::size_t i = 0; i < log.way.size(); ++i) {
    if (log.has_odometry && i > 0 && !log.is_missing(i)) {
      SE2 motion = log.odometry(i, log.way[i - 1].between(log.way[i]));
      const SE2 error(0.005 * noise(random), 0.0, 0.003 * noise(random));
      if (!motion.log().isZero()) motion = motion * error;  // wheels that rest count nothing
      objects.push_back(motion_2d({motion.x(), motion.y(), motion.angle()}, 0.02));
    }
    const LaserScan seen = log.plan.scan(log.way[i], 181, 0.01, random);
    auto scan = CObservation2DRangeScan::Create();
    scan->timestamp = mrpt::Clock::fromDouble(log.time(i));
    scan->aperture = static_cast<float>(M_PI);
    scan->maxRange = 30;
    scan->resizeScan(seen.ranges.size());
    for (std::size_t k = 0; k < seen.ranges.size(); ++k) {
      scan->setScanRange(k, std::isfinite(seen.ranges[k]) ? seen.ranges[k] : 30);
      scan->setScanRangeValidity(k, std::isfinite(seen.ranges[k]));
    }
    log.spoil(i, *scan);
    objects.push_back(frame({scan}));
  }
  write_log(path, objects);
}

}  // namespace hybrid
