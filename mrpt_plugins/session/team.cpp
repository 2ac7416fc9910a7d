// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/team.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/standard_input.h"
#include "mrpt_plugins/session/detail/find_start.h"
#include "mrpt_plugins/session/detail/meeting.h"

namespace hybrid {
namespace {

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

/// A start that is given, as laser scans in the map say where it is.
KnownStart refined(const ReplayRequest& request, const ReplaySettings& settings, std::size_t robot,
                   const MapRecord& known, const KnownStart& given) {
  if (is_standard_input(settings.robots[robot].rawlog)) return given;
  return refine_start(request, robot, known, settings.map.odds, given).value_or(given);
}

}  // namespace

Team::Team(const ReplayRequest& request, ReplaySettings& settings, const MapRecord& known,
           bool is_3d) {
  std::vector<RobotSettings>& robots = settings.robots;
  members_.resize(robots.size());
  const bool has_map = holds_places(known);
  if (robots.size() == 1 && !has_map) return;
  const ReplayRequest chosen = with_chosen_plugins(request, settings);
  std::vector<std::size_t> lost;
  const auto enter = [&](std::size_t i, const FoundStart& found) {
    robots[i].options.motion.start = found.start;
    robots[i].options.motion.start->found = !members_[i].given && !found.by_scans;
    members_[i].given = members_[i].given || found.by_scans;
    members_[i].known_at = found.keyframe;
  };
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (const auto given = given_start(robots[i].start, is_3d)) {
      members_[i].given = true;
      enter(i, {refined(chosen, settings, i, known, *given), 0});
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
  Meeting meeting(chosen, settings, in_map_ ? known : MapRecord());
  for (std::size_t i = 0; in_map_ && i < robots.size(); ++i) {
    if (members_[i].known_at && !members_[i].given) meeting.find(i);
  }
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (members_[i].given) meeting.place(i, Eigen::Isometry3d::Identity());
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
  std::string remarks;  // on their logs, which may be why
  for (auto i = lost.rbegin(); i != lost.rend(); ++i) {
    const auto at = static_cast<std::ptrdiff_t>(*i);
    names.insert(names.begin(), robots[*i].name);
    for (const std::string& remark : robots[*i].findings.remarks) {
      remarks += "; robot " + robots[*i].name + " " + remark;
    }
    robots.erase(robots.begin() + at);
    members_.erase(members_.begin() + at);
  }
  message_ = fmt::format(
                 "left out {}: no place in the map of the others stands out; give its start in "
                 "[robot.NAME]",
                 fmt::join(names, ", ")) +
             remarks;
}

void Team::added(std::size_t robot, Mapper& mapper) {
  Member& member = members_[robot];
  if (member.known_at && !member.given && member.keyframes == *member.known_at) {
    mapper.forget_start(robot);
  }
  ++member.keyframes;
}

}  // namespace hybrid
