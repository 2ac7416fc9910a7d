// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/run_summary.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>

#include "libhybrid/core/infinity.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/health/unit_words.h"
#include "mrpt_plugins/mapping/plugin_choice.h"

namespace hybrid {
namespace {

/// Whether something odd in a log was dropped, repaired or missing; the rest is for information.
bool is_loss(const std::string& what) {
  const auto has = [&](const char* word) { return what.find(word) != std::string::npos; };
  return has(" dropped: ") || has(" repaired: ") || has(" missing: a gap");
}

/// What of the log could not become part of the map, and why; "" where all could.
std::string refusals(const Mapper& mapper) {
  if (mapper.warnings().empty()) return "";
  std::size_t count = 0;
  for (const auto& [reason, times] : mapper.dropped()) {
    if (reason.find(" dropped: not ") != std::string::npos) count += times;
  }
  return fmt::format("left out as not usable {} time{}, first in {}", count, count == 1 ? "" : "s",
                     mapper.warnings().front());
}

/// Why scans or clouds of which each saw something tell no motion.
std::string why_unrelated(double count, const char* one, const char* many, std::size_t keyframes) {
  if (count == 1) {
    return fmt::format("nothing was mapped: there is one {}, and only two tell a motion", one);
  }
  return fmt::format(
      "nothing was mapped: there are {:.0f} {} but only {} keyframe{}: the robot hardly moves, or "
      "the thresholds of [keyframes] are large",
      count, many, keyframes, keyframes == 1 ? "" : "s");
}

/// Why nothing but dead reckoning came out.
std::string why_empty(const Mapper& mapper, const Summary& summary) {
  const std::map<std::string, double> figures = mapper.statistics();
  const auto figure = [&](const char* name) {
    const auto found = figures.find(name);
    return found == figures.end() ? 0.0 : found->second;
  };
  if (figure("fixes") > 0) {
    return fmt::format(
        "nothing was mapped: none of {:.0f} fixes was used, and the path is dead reckoning; what "
        "was dropped tells why",
        figure("fixes"));
  }
  if (const double clouds = figure("clouds"); clouds > 0) {
    const double blind = figure("clouds_blind"), lost = figure("clouds_lost");
    if (blind + lost == 0) return why_unrelated(clouds, "cloud", "clouds", summary.keyframes);
    return fmt::format(
        "nothing was mapped: of {:.0f} clouds {:.0f} show no surface, and {:.0f} agree with none "
        "before them",
        clouds, blind, lost);
  }
  const double scans = figure("scans");
  if (scans == 0) return why_nothing_mapped(summary.observations, summary.dropped);
  const double blind = figure("scans_blind"), lost = figure("scans_lost");
  if (blind + lost == 0) return why_unrelated(scans, "scan", "scans", summary.keyframes);
  const bool is_blind = blind >= lost;
  return fmt::format(
      "nothing was mapped: {:.0f} of {:.0f} scans {}, and the path is dead reckoning",
      is_blind ? blind : lost, scans,
      is_blind ? "have fewer than ten returns within the maximum range"
               : "agree with none before them, as those of ranges with errors of "
                 "decimetres");
}

/// Sets status and message; `signal` is what stopped the replay, or 0.
void set_status(const LogMerge& source, const Mapper& mapper, const MapResult& result, int signal,
                Summary& summary) {
  const std::string refused = refusals(mapper);
  if (signal != 0) {
    summary.status = "interrupted";
    summary.message = fmt::format("stopped by {} after {} keyframes", signal_name(signal),
                                  result.trajectory.size());
    if (const auto share = source.progress()) {
      summary.message += fmt::format(", {:.1f} % of the log", 100 * *share);
    }
  } else if (source.status() != LogStatus::kComplete) {
    summary.status = "partial";
    summary.message = source.message();
  } else if (result.landmarks.empty() && mapper.measurements() == 0 && refused.empty()) {
    summary.status = "empty";
    summary.message = why_empty(mapper, summary);
  } else if (!refused.empty()) {
    summary.status = "partial";
  }
  if (refused.empty()) return;
  summary.message += (summary.message.empty() ? "" : "; ") + refused;
}

/// What of the log was dropped or is missing, and why; what else is odd is a warning.
void tell_dropped(const LogMerge& source, const Mapper& mapper, Summary& summary) {
  summary.dropped = source.dropped();
  for (const auto& [reason, count] : mapper.dropped()) summary.dropped[reason] += count;
  for (const auto& [what, count] : source.warnings()) {
    if (is_loss(what)) {
      summary.dropped[what] += count;
      continue;
    }
    summary.warnings.push_back(count == 1 ? what : fmt::format("{} ({} times)", what, count));
  }
}

/// Length of the path of one robot, or of the paths of several [m].
double length_of(const MapResult& result) {
  const auto length = [](const Trajectory& path) {
    double sum = 0;
    for (std::size_t i = 1; i < path.size(); ++i) {
      sum += path[i].pose.distanceTo(path[i - 1].pose);
    }
    return sum;
  };
  if (result.robots.empty()) return length(result.trajectory);
  double sum = 0;
  for (const RobotPath& robot : result.robots) sum += length(part_of(result.trajectory, robot));
  return sum;
}

/// How messages name a robot, with a blank; "" where there is but one.
std::string prefix_of(const RobotSettings& robot) {
  return robot.name.empty() ? "" : robot.name + " ";
}

/// What was found of the logs before they were mapped, and is not used in this map.
void judge_contradictions(const ReplaySettings& settings, Health& health) {
  std::vector<std::string> sensors;
  for (const RobotSettings& robot : settings.robots) {
    for (const AlignmentRecord& record : robot.findings.alignment) {
      const auto used = robot.source.correction.sensors.find(record.sensor);
      if (used != robot.source.correction.sensors.end()) continue;
      sensors.push_back(fmt::format(
          "{}{}: {}", prefix_of(robot), record.sensor,
          record.length != 1
              ? fmt::format("ranges fit when multiplied by {:.4g}", record.length)
              : fmt::format("bearings fit with the other sign, by {:.0f} standard deviations",
                            record.mirror_sigmas)));
    }
  }
  if (sensors.empty()) return;
  health.push_back(
      judged_entry("sensors against odometry", static_cast<double>(sensors.size()), {0, kInfinity},
                   fmt::format("Sensors that the odometry of their robot contradicts: {}.",
                               fmt::join(sensors, "; ")),
                   "sign and unit of the detections, and sign of the odometry, of this robot"));
  health.back().is_optional = true;  // a map of what was measured lacks it
}

}  // namespace

void tell_findings(const ReplaySettings& settings, Summary& summary) {
  for (const RobotSettings& robot : settings.robots) {
    const std::string name = prefix_of(robot);
    for (NoiseRecord record : robot.findings.noise) {
      record.sensor = name + record.sensor;
      summary.noise.push_back(std::move(record));
    }
    for (AlignmentRecord record : robot.findings.alignment) {
      record.sensor = name + record.sensor;
      summary.alignment.push_back(std::move(record));
    }
    for (const std::string& remark : robot.findings.remarks) {
      summary.warnings.push_back((name.empty() ? "" : "robot " + name) + remark);
    }
  }
}

void judge_findings(const ReplaySettings& settings, Health& health) {
  judge_contradictions(settings, health);
  std::string sensors;
  double count = 0;
  for (const RobotSettings& robot : settings.robots) {
    for (const NoiseRecord& record : robot.findings.noise) {
      if (!record.measured || record.why.empty()) continue;
      ++count;
      sensors += fmt::format("{}{}{} {} {:.3g} {}", count > 1 ? ", " : "", prefix_of(robot),
                             record.sensor, record.kind, *record.measured, record.unit);
    }
  }
  if (count == 0) return;
  health.push_back(judged_entry(
      "noise that was measured", count, {0, 0},
      fmt::format("No sensor has the noise that was measured ({}): it is not used.", sensors),
      "ids, sign and pose of the sensor, odometry"));
}

void warn(Summary& summary, const std::vector<std::string>& more) {
  summary.warnings.insert(summary.warnings.end(), more.begin(), more.end());
}

Summary summarize(const Session& session, const MapResult& result) {
  const LogMerge& source = session.source();
  const Mapper& mapper = session.mapper();
  const BackendReport& last = session.last();
  Summary summary;
  summary.observations = observation_uses(source.observations(), session.plugins());
  summary.keyframes = result.trajectory.size();
  tell_dropped(source, mapper, summary);
  set_status(source, mapper, result, session.signal(), summary);
  summary.mode = mapper.backend().mode();
  summary.landmarks = result.landmarks.size();
  summary.movers = result.movers.size();
  summary.path_m = length_of(result);
  summary.objective = last.objective_after;
  summary.cost = last.cost;
  summary.steps = step_statistics(result.steps);
  summary.plugins = plugin_statistics(result.steps);
  summary.statistics = mapper.statistics();
  summary.solver_s = summary.steps.total_s + last.seconds;
  warn(summary, mapper.warnings());
  warn(summary, last.warnings);
  summary.calibration = result.calibration;
  warn(summary, unit_words(result.calibration));
  summary.fixes = fix_figures(result);
  for (const int mode : result.motion_modes) {
    if (mode >= 0) ++summary.modes[result.mode_names[static_cast<std::size_t>(mode)]];
  }
  return summary;
}

}  // namespace hybrid
