// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/plugin_choice.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

namespace hybrid {
namespace {

bool uses(const MappingPlugin& plugin, const std::string& observation) {
  const std::vector<std::string> used = plugin.uses();
  return std::any_of(used.begin(), used.end(), [&](const std::string& name) {
    return without_namespace(name) == observation;
  });
}

std::string name_of(const MappingPlugin& plugin) {
  return without_namespace(plugin.GetRuntimeClass()->className);
}

/// The loaded file that contains a static object.
const void* file_of(const void* thing) {
  Dl_info place{};
  return ::dladdr(thing, &place) != 0 ? place.dli_fbase : nullptr;
}

/// Whether the class of a plugin is built into this program rather than loaded by the user.
bool is_own(const MappingPlugin& plugin) {
  static const int here = 0;
  return file_of(plugin.GetRuntimeClass()) == file_of(&here);
}

/// One unconfigured object of every registered class of plugins, sorted by name.
std::vector<std::shared_ptr<MappingPlugin>> samples() {
  std::map<std::string, std::shared_ptr<MappingPlugin>> samples;
  for (const auto* id : mrpt::rtti::getAllRegisteredClassesChildrenOf(CLASS_ID(MappingPlugin))) {
    if (!id->ptrCreateObject) continue;
    auto plugin = std::dynamic_pointer_cast<MappingPlugin>(id->createObject());
    samples.emplace(name_of(*plugin), std::move(plugin));
  }
  std::vector<std::shared_ptr<MappingPlugin>> out;
  for (auto& [name, plugin] : samples) out.push_back(std::move(plugin));
  return out;
}

}  // namespace

std::vector<std::string> choose_plugins(const LogContents& log) {
  std::vector<std::shared_ptr<MappingPlugin>> suitable = samples();
  suitable.erase(std::remove_if(suitable.begin(), suitable.end(),
                                [&](const auto& plugin) { return !plugin->suits(log); }),
                 suitable.end());
  std::set<std::string> taken;
  for (const auto& plugin : suitable) {
    if (is_own(*plugin)) continue;
    for (const auto& [name, count] : log.observations) {
      if (uses(*plugin, name)) taken.insert(name);
    }
  }
  std::vector<std::string> chosen;
  for (const auto& plugin : suitable) {
    const bool is_left_to_others =
        is_own(*plugin) && std::any_of(taken.begin(), taken.end(), [&](const std::string& name) {
          return uses(*plugin, name);
        });
    if (!is_left_to_others) chosen.push_back(name_of(*plugin));
  }
  return chosen;
}

/// The class that a log has its odometry in; poses of the robot where it has no other.
std::string odometry_in(const std::map<std::string, std::size_t>& observations) {
  const bool has_own = observations.count("CObservationOdometry") != 0;
  return has_own ? "CObservationOdometry" : "CObservationRobotPose";
}

std::map<std::string, ObservationUse> observation_uses(
    const std::map<std::string, std::size_t>& observations,
    const std::vector<std::shared_ptr<MappingPlugin>>& plugins) {
  std::map<std::string, ObservationUse> out;
  const std::string odometry = odometry_in(observations);
  for (const auto& [name, count] : observations) {
    if (name == "CObservationComment") continue;
    ObservationUse use{count, {}};
    if (name == odometry) use.users.push_back("odometry");
    for (const auto& plugin : plugins) {
      if (uses(*plugin, name)) use.users.push_back(name_of(*plugin));
    }
    out.emplace(name, std::move(use));
  }
  return out;
}

namespace {

/// A kind of observation that tells of the path without landmarks.
struct Kind {
  const char *class_name, *one, *many;
  const char* advice;  ///< where nothing of it was dropped
};

constexpr Kind kKinds[] = {
    {"CObservationGPS", "fix", "fixes",
     "two that agree with each other and with the odometry are needed to begin with"},
    {"CObservation2DRangeScan", "scan", "scans",
     "which rays of the log are valid, and what is their maximum range?"},
    {"CObservationPointCloud", "cloud", "clouds",
     "are its points in the log, and is the map one in space ([map] dimension)?"}};

/// What was dropped of observations of a kind, and why, else the advice.
std::string reasons_for(const Kind& kind, const std::map<std::string, std::size_t>& dropped) {
  const std::string start = fmt::format("{} dropped: ", kind.one);
  std::vector<std::string> reasons;
  for (const auto& [reason, count] : dropped) {
    if (reason.rfind(start, 0) != 0) continue;
    reasons.push_back(fmt::format("{} ({})", reason.substr(start.size()), count));
  }
  if (reasons.empty()) return kind.advice;
  return fmt::format("dropped: {}", fmt::join(reasons, ", "));
}

/// Why nothing came of the observations of one class.
std::string why_unused(const std::string& class_name, std::size_t count,
                       const std::map<std::string, std::size_t>& dropped) {
  for (const Kind& kind : kKinds) {
    if (class_name != kind.class_name) continue;
    return fmt::format("nothing was mapped: {}, and the path is dead reckoning; {}",
                       count == 1 ? fmt::format("the one {} of the log was not used", kind.one)
                                  : fmt::format("none of {} {} was used", count, kind.many),
                       reasons_for(kind, dropped));
  }
  return "no landmark was mapped: nothing that the plugins saw became a landmark: are odometry and "
         "ranges in metres, angles in radians, and the pose of the sensor right? Directions "
         "without ranges place only what the robot passes. What was dropped tells more";
}

}  // namespace

std::string why_nothing_mapped(const std::map<std::string, ObservationUse>& uses_of_log,
                               const std::map<std::string, std::size_t>& dropped) {
  std::vector<std::string> unused;
  std::set<std::string> told;
  std::string advice = "-p loads further plugins";
  for (const auto& [name, use] : uses_of_log) {
    if (name == "CObservationOdometry" || name == "CObservationRobotPose") continue;
    if (!use.users.empty()) told.insert(why_unused(name, use.count, dropped));
    if (!told.empty()) continue;
    std::vector<std::string> could;
    for (const auto& plugin : samples()) {
      if (uses(*plugin, name)) could.push_back(name_of(*plugin));
    }
    unused.push_back(fmt::format("{} {}", use.count, name));
    if (could.empty()) continue;
    unused.back() += fmt::format(" for {}", fmt::join(could, " or "));
    advice = "[plugins] classes = auto chooses what suits a log";
  }
  if (!told.empty()) return fmt::format("{}", fmt::join(told, "; "));
  if (unused.empty()) return "no landmark was mapped: the log holds no observations of landmarks";
  return fmt::format(
      "no landmark was mapped: no plugin that was chosen uses what the log holds, {}; {}",
      fmt::join(unused, ", "), advice);
}

}  // namespace hybrid
