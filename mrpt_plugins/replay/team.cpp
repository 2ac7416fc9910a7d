// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/detail/team.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "libhybrid/maps/join_maps.h"
#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/replay/detail/map_run.h"

namespace hybrid {
namespace {

/// The map that one robot makes alone.
MapRecord map_alone(const ReplayRequest& request, std::size_t robot) {
  const auto ini = open_config(request);
  ReplaySettings settings = read_settings(*ini, request);
  settings.robots = {std::move(settings.robots[robot])};
  RobotOptions& options = settings.robots.front().options;
  options.motion.start.reset();
  LogMerge log = open_logs(settings);
  Mapper mapper = make_mapper(settings, log.is_3d());
  return about({settings.robots.front().rawlog}, [&] {
    while (const auto keyframe = log.next()) {
      throw_if_interrupted();
      mapper.add(*keyframe);
    }
    mapper.finish();
    return record_of(mapper, mapper.result());
  });
}

/// Robots of which a joint map is made, one after the other.
class Meeting {
 public:
  Meeting(ReplayRequest request, double odds) : request_(std::move(request)), odds_(odds) {}

  /// Where robot `i` starts in the frame of robot 0; nothing where that cannot be told yet.
  std::optional<KnownStart> find(std::size_t i) {
    const MapRecord own = map_of(i);
    if (own.landmarks.empty() || joint().landmarks.empty()) return std::nullopt;
    auto joined = join_maps(joint(), own, odds_);
    if (!joined) return std::nullopt;
    joint_ = std::move(joined->map);
    return KnownStart{joined->T_first_second, joined->variance_factor * joined->covariance};
  }

 private:
  const MapRecord& map_of(std::size_t i) {
    const auto it = maps_.find(i);
    return it != maps_.end() ? it->second : maps_.emplace(i, map_alone(request_, i)).first->second;
  }
  MapRecord& joint() {
    if (!joint_) joint_ = map_of(0);
    return *joint_;
  }

  ReplayRequest request_;
  double odds_;
  std::map<std::size_t, MapRecord> maps_;
  std::optional<MapRecord> joint_;
};

}  // namespace

Team::Team(const ReplayRequest& request, ReplaySettings& settings) {
  std::vector<RobotSettings>& robots = settings.robots;
  if (robots.size() == 1) return;
  if (!settings.map.file.empty()) {
    throw Error(settings.map.file +
                ": a map file takes the logs of several robots one after the other, not at once");
  }
  std::set<std::size_t> lost;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const bool is_3d = KeyframeSource(robots[i].rawlog, robots[i].source).is_3d();
    robots[i].options.motion.start = given_start(robots[i].start, is_3d);
    if (i > 0 && !robots[i].options.motion.start) lost.insert(i);
  }
  Meeting meeting(with_chosen_plugins(request, settings), settings.map.odds);
  std::set<std::size_t> found;
  for (bool again = true; again && !lost.empty();) {  // one may be found through another
    again = false;
    for (const std::size_t i : std::vector<std::size_t>(lost.begin(), lost.end())) {
      auto start = meeting.find(i);
      if (!start) continue;
      robots[i].options.motion.start = std::move(start);
      lost.erase(i);
      found.insert(i);
      again = true;
    }
  }
  std::vector<RobotSettings> kept;
  std::vector<std::string> left_out;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (lost.count(i) != 0) {
      left_out.push_back(robots[i].name);
      continue;
    }
    if (found.count(i) != 0) found_.push_back(kept.size());
    kept.push_back(std::move(robots[i]));
  }
  robots = std::move(kept);
  if (left_out.empty()) return;
  message_ = fmt::format(
      "left out {}: no place in the map of the others stands out; give its start in [robot.NAME]",
      fmt::join(left_out, ", "));
}

void Team::settle(Mapper& mapper) const {
  for (const std::size_t i : found_) mapper.forget_start(i);
}

}  // namespace hybrid
