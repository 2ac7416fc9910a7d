// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/detail/team.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/maps/join_maps.h"
#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/bridge/detail/standard_input.h"
#include "mrpt_plugins/replay/detail/find_start.h"
#include "mrpt_plugins/replay/detail/map_run.h"

namespace hybrid {
namespace {

/// The map that one robot makes alone, in the frame of its first pose or where that is given.
struct OwnMap {
  MapRecord map;
  std::size_t keyframes = 0;
};

OwnMap map_alone(const ReplayRequest& request, std::size_t robot) {
  const auto ini = open_config(request);
  ReplaySettings settings = read_settings(*ini, request);
  settings.robots = {std::move(settings.robots[robot])};
  RobotSettings& own = settings.robots.front();
  LogMerge log = open_logs(settings);
  own.options.motion.start = given_start(own.start, log.is_3d());
  Mapper mapper = make_mapper(settings, log.is_3d());
  return about({own.rawlog}, [&] {
    OwnMap out;
    for (; const auto keyframe = log.next(); ++out.keyframes) {
      throw_if_interrupted();
      mapper.add(*keyframe);
    }
    mapper.finish();
    out.map = record_of(mapper, mapper.result());
    return out;
  });
}

/// Robots of which a joint map is made, one after the other.
class Meeting {
 public:
  Meeting(const ReplayRequest& request, double odds, MapRecord joint)
      : request_(request), odds_(odds), joint_(std::move(joint)) {}

  /// Where robot `i` starts in the frame of the joint map, which its own is then part of; nothing
  /// where that cannot be told yet.
  std::optional<FoundStart> find(std::size_t i) {
    auto it = maps_.find(i);
    if (it == maps_.end()) it = maps_.emplace(i, map_alone(request_, i)).first;
    const OwnMap& own = it->second;
    if (own.map.landmarks.empty() || joint_.landmarks.empty()) return std::nullopt;
    auto joined = join_maps(joint_, own.map, odds_);
    if (!joined) return std::nullopt;
    joint_ = std::move(joined->map);
    return FoundStart{{joined->T_first_second, joined->variance_factor * joined->covariance},
                      own.keyframes - 1};
  }

 private:
  const ReplayRequest& request_;
  double odds_;
  MapRecord joint_;
  std::map<std::size_t, OwnMap> maps_;
};

/// Where a robot starts in a known map, by its landmarks as they come.
std::optional<FoundStart> find_in_map(const ReplayRequest& request, const ReplaySettings& settings,
                                      std::size_t robot, const MapRecord& known) {
  const MapOptions& map = settings.map;
  if (is_standard_input(settings.robots[robot].rawlog)) {
    throw Error(map.file +
                ": the place in it is found by reading the log before, which standard input does "
                "not allow; give [map] start");
  }
  return find_start(request, robot, known, map.odds);
}

}  // namespace

Team::Team(const ReplayRequest& request, ReplaySettings& settings, const MapRecord& known,
           bool is_3d) {
  std::vector<RobotSettings>& robots = settings.robots;
  members_.resize(robots.size());
  const bool has_map = !known.landmarks.empty();
  if (robots.size() == 1 && !has_map) return;
  const ReplayRequest chosen = with_chosen_plugins(request, settings);
  std::vector<std::size_t> lost;
  const auto enter = [&](std::size_t i, const FoundStart& found) {
    robots[i].options.motion.start = found.start;
    members_[i].known_at = found.keyframe;
  };
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (const auto given = given_start(robots[i].start, is_3d)) {
      enter(i, {*given, 0});
      members_[i].given = true;
    } else if (const auto found =
                   has_map ? find_in_map(chosen, settings, i, known) : std::nullopt) {
      enter(i, *found);
    } else {
      lost.push_back(i);
    }
  }
  in_map_ = has_map && lost.size() < robots.size();
  if (!in_map_ && !lost.empty() && lost.front() == 0) lost.erase(lost.begin());  // the frame's own
  if (lost.empty()) return;
  Meeting meeting(chosen, settings.map.odds, in_map_ ? known : map_alone(chosen, 0).map);
  for (std::size_t i = 0; in_map_ && i < robots.size(); ++i) {
    if (members_[i].known_at && !members_[i].given) meeting.find(i);
  }
  for (bool again = true; again && !lost.empty();) {  // one may be found through another
    again = false;
    for (const std::size_t i : std::vector<std::size_t>(lost)) {
      const auto found = meeting.find(i);
      if (!found) continue;
      enter(i, *found);
      lost.erase(std::find(lost.begin(), lost.end(), i));
      again = true;
    }
  }
  leave_out(lost, robots);
}

void Team::leave_out(const std::vector<std::size_t>& lost, std::vector<RobotSettings>& robots) {
  if (lost.empty()) return;
  std::vector<std::string> names;
  for (auto i = lost.rbegin(); i != lost.rend(); ++i) {
    const auto at = static_cast<std::ptrdiff_t>(*i);
    names.insert(names.begin(), robots[*i].name);
    robots.erase(robots.begin() + at);
    members_.erase(members_.begin() + at);
  }
  message_ = fmt::format(
      "left out {}: no place in the map of the others stands out; give its start in [robot.NAME]",
      fmt::join(names, ", "));
}

void Team::added(std::size_t robot, Mapper& mapper) {
  Member& member = members_[robot];
  if (member.known_at && !member.given && member.keyframes == *member.known_at) {
    mapper.forget_start(robot);
  }
  ++member.keyframes;
}

}  // namespace hybrid
