// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/detail/open_logs.h"

#include <utility>

namespace hybrid {

LogMerge open_logs(const ReplaySettings& settings) {
  LogMerge logs;
  for (const RobotSettings& robot : settings.robots)
    logs.add(robot.name, robot.rawlog, robot.source);
  return logs;
}

Mapper make_mapper(ReplaySettings& settings, bool is_3d) {
  std::vector<RobotOptions> robots;
  for (const RobotSettings& robot : settings.robots) {
    robots.push_back(robot.options);
    if (!settings.sightings) robots.back().id.reset();
  }
  const Loss loss = settings.huber_width > 0 ? Loss::huber(settings.huber_width) : Loss();
  return {std::move(robots), std::move(settings.plugins), std::move(settings.backend), is_3d, loss};
}

}  // namespace hybrid
