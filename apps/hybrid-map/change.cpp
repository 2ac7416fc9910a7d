// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// The commands that write a map.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "apps/exit_code.h"
#include "apps/hybrid-map/commands.h"
#include "apps/program.h"
#include "libhybrid/clouds/cloud_join.h"
#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/map_file/export_map.h"
#include "mrpt_plugins/map_file/map_file.h"

namespace hybrid {
namespace {

constexpr double kExact = 1e-3;  // m, rad

/// Reads a map, all of whose sessions must be complete.
MapRecord whole_map(const std::string& file) {
  MapRecord map = read_map(file);
  for (const MapSession& s : map.sessions) {
    if (!s.complete) {
      throw Error(
          fmt::format("{}: session {} was interrupted; resume or prune it first", file, s.id));
    }
  }
  if (!holds_places(map)) throw Error(file + ": holds no landmark, no laser scans and no clouds");
  return map;
}

/// Joins two maps by their places on earth, if fixes have told both.
std::optional<JoinedMaps> joined_by_fixes(const MapRecord& first, const MapRecord& second) {
  const auto T = motion_by_fixes(first.origin, second.origin, first.is_3d);
  if (!T) return std::nullopt;
  const int size = first.is_3d ? 6 : 3;
  // What is not known of their places is part of what the maps know of their landmarks.
  const Eigen::MatrixXd exact = kExact * kExact * Eigen::MatrixXd::Identity(size, size);
  return join_maps_at(first, second, *T, exact);
}

/// Joins two maps by landmarks that both have, else by laser scans or clouds, else by fixes; `why`
/// tells why not.
std::optional<JoinedMaps> joined_by_any(const MapRecord& first, const MapRecord& second,
                                        double odds, std::string& why) {
  why = "no common place with the other maps stands out";
  if (!first.landmarks.empty() && !second.landmarks.empty()) {
    if (auto joined = join_maps(first, second, odds)) return joined;
  }
  std::string by_places;
  if (auto joined = join_maps_by_places(first, second, odds, by_places)) return joined;
  if (!by_places.empty()) why += ": " + by_places;
  return joined_by_fixes(first, second);
}

/// What there is to say of a map that was joined.
void tell(const std::string& file, const JoinedMaps& joined) {
  const Eigen::Vector3d t = joined.T_first_second.translation();
  const Eigen::Matrix3d R = joined.T_first_second.linear();
  const char* views = joined.map.is_3d ? "clouds" : "laser scans";
  const std::string by = joined.scan_matches > 0
                             ? fmt::format("{} matches of {}, ", joined.scan_matches, views)
                         : joined.was_known ? "by fixes of satellites, "
                                            : "";
  say("{}: {}{} landmarks in common, at ({:.3f} {:.3f} {:.3f}) m, {:.2f} deg, log odds {:.1f}\n",
      file, by, joined.common, t.x(), t.y(), t.z(), std::atan2(R(1, 0), R(0, 0)) * 180 / M_PI,
      joined.log_odds);
  if (joined.variance_factor > 1) {
    say("{}: these differ by more than the maps say they may; their variances would have to be "
        "{:.1f} times larger\n",
        file, joined.variance_factor);
  }
  for (const Contradiction& c : joined.contradictions) {
    say("{}: landmark {} lies {:.2f} m from where the other maps have it; it is left out {}\n",
        file, c.id, c.distance, c.first_kept ? "there" : "of those, where it was seen less often");
  }
}

/// Removes the keyframes of a robot from all sessions. Throws Error where that cannot be.
void remove_keyframes(const std::string& file, const std::string& robot, MapRecord& map) {
  bool known = false;
  for (MapSession& session : map.sessions) {
    const auto it = std::find(session.robots.begin(), session.robots.end(), robot);
    if (it == session.robots.end()) continue;
    known = true;
    if (!session.complete) {
      throw Error(
          fmt::format("{}: session {} was interrupted; resume it or remove all of it with "
                      "--session {}",
                      file, session.id, session.id));
    }
    const auto number = static_cast<std::size_t>(it - session.robots.begin());
    auto& all = session.keyframes;
    all.erase(std::remove_if(all.begin(), all.end(),
                             [&](const MapKeyframe& k) { return k.robot == number; }),
              all.end());
  }
  if (!known) throw Error(fmt::format("{}: has no robot {}", file, escaped(robot)));
}

}  // namespace

int join(const Options& options) {
  for (const std::string& file : options.maps) {
    std::error_code unknown;
    if (std::filesystem::equivalent(file, options.output, unknown)) {
      throw Error(options.output + ": is one of the maps to join; name a new file");
    }
  }
  std::error_code unknown;
  if (std::filesystem::exists(options.output, unknown) &&
      std::filesystem::file_size(options.output, unknown) > 0 &&
      !read_map(options.output).sessions.empty()) {
    throw Error(options.output + ": holds a map already; name a new file");
  }
  MapRecord all = whole_map(options.maps.front());
  std::vector<std::string> left(options.maps.begin() + 1, options.maps.end());
  std::string why;
  // A map may overlap the first one only through another one.
  for (bool progress = true; progress && !left.empty();) {
    progress = false;
    for (auto it = left.begin(); it != left.end();) {
      const MapRecord next = whole_map(*it);
      std::string doubt;
      const auto joined = about(std::vector<std::string>{*it},
                                [&] { return joined_by_any(all, next, options.odds, doubt); });
      if (it == left.begin()) why = doubt;
      if (!joined) {
        ++it;
        continue;
      }
      tell(*it, *joined);
      all = joined->map;
      it = left.erase(it);
      progress = true;
    }
  }
  if (!left.empty()) {
    throw Error(left.front() + ": " + why + "; nothing was merged");
  }
  MapFile file(options.output);
  file.replace(all);
  say("{} landmarks{}, {} sessions -> {}\n", all.landmarks.size(), places_text(all),
      all.sessions.size(), options.output);
  return kExitOk;
}

int prune(const Options& options) {
  const std::string& name = options.maps[0];
  if (options.sessions.empty() && options.robots.empty() && !options.vanished) {
    throw Error(name + ": nothing to remove: name a --session, a --robot, or --vanished");
  }
  read_map(name);  // throws if the map is missing, so that none is created
  MapFile file(name);
  MapRecord map = file.record();
  for (const int id : options.sessions) {
    const auto it = std::find_if(map.sessions.begin(), map.sessions.end(),
                                 [id](const MapSession& s) { return s.id == id; });
    if (it == map.sessions.end()) throw Error(fmt::format("{}: has no session {}", name, id));
    if (!it->complete) {
      map.sessions.erase(it);
    } else {
      it->keyframes.clear();
      forget_local_maps(map, id);
    }
  }
  for (const std::string& robot : options.robots) remove_keyframes(name, robot, map);
  std::vector<std::int64_t> gone;
  for (const MapLandmark& l : map.landmarks) {
    if (options.vanished && !exists(l)) gone.push_back(l.id);
  }
  if (!gone.empty()) map = without_landmarks(map, gone);
  file.replace(map);
  say("{}: {} landmarks, {} sessions\n", name, map.landmarks.size(), map.sessions.size());
  return kExitOk;
}

}  // namespace hybrid
