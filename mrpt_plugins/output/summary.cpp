// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "mrpt_plugins/health/health_json.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const TrajectoryErrors& e) {
  return {{"mean_m", e.mean_m},
          {"rmse_m", e.rmse_m},
          {"max_m", e.max_m},
          {"rotation_mean_deg", e.rotation_mean_deg},
          {"rotation_rmse_deg", e.rotation_rmse_deg}};
}

Json to_json(const TrajectoryReport& report) {
  Json out = to_json(report.unaligned);
  out["poses"] = report.poses;
  out["aligned"] = to_json(report.aligned);
  for (const RelativeError& e : report.relative) {
    out["relative"].push_back({{"distance_m", e.distance_m},
                               {"stretches", e.stretches},
                               {"translation_m", e.translation_m},
                               {"rotation_deg", e.rotation_deg}});
  }
  return out;
}

Json to_json(const LandmarkErrors& e) {
  return {{"matched", e.matched}, {"spurious", e.spurious},
          {"missed", e.missed},   {"precision", e.precision()},
          {"recall", e.recall()}, {"mean_m", e.mean_m},
          {"max_m", e.max_m}};
}

Json to_json(const AssociationReport& a) {
  return {{"labelled", a.labelled},
          {"right", a.right},
          {"rejected", a.rejected},
          {"unlabelled", a.unlabelled},
          {"unlabelled_rejected", a.unlabelled_rejected}};
}

Json to_json(const MoverReport& m) {
  Json out = {{"things", m.things},
              {"sightings", m.sightings},
              {"kept_out", m.kept_out},
              {"followed", m.followed},
              {"false_sightings", m.false_sightings},
              {"states", m.states}};
  if (m.sightings > 0) out["kept_out_share"] = m.kept_out_share();
  if (m.states > 0) {
    out["mean_m"] = m.mean_m;
    out["max_m"] = m.max_m;
    out["relative_mean_m"] = m.relative_mean_m;
  }
  return out;
}

Json to_json(const StepStatistics& s) {
  return {{"total_s", s.total_s}, {"mean_ms", s.mean_ms}, {"p50_ms", s.p50_ms},
          {"p95_ms", s.p95_ms},   {"p99_ms", s.p99_ms},   {"max_ms", s.max_ms}};
}

Json to_json(const DetectionScore& s) {
  return {
      {"real", s.real}, {"found", s.found}, {"precision", s.precision()}, {"recall", s.recall()}};
}

Json to_json(const TruthSummary& t) {
  Json out = Json::object();
  if (t.trajectory) out["trajectory"] = to_json(*t.trajectory);
  if (t.dead_reckoning) out["dead_reckoning"] = to_json(*t.dead_reckoning);
  if (t.landmarks) out["landmarks"] = to_json(*t.landmarks);
  if (t.landmarks_aligned) {
    out["landmarks"]["aligned"] = {{"mean_m", t.landmarks_aligned->mean_m},
                                   {"max_m", t.landmarks_aligned->max_m}};
  }
  if (t.class_accuracy) out["class_accuracy"] = *t.class_accuracy;
  if (t.associations) {
    if (t.associations->labelled > 0) out["association_accuracy"] = t.associations->accuracy();
    out["associations"] = to_json(*t.associations);
  }
  if (t.movers) out["movers"] = to_json(*t.movers);
  if (t.nees_pose) out["nees_pose"] = *t.nees_pose;
  if (t.loop_precision) out["loop_precision"] = *t.loop_precision;
  if (t.loop_recall) out["loop_recall"] = *t.loop_recall;
  if (t.nees_landmark) out["nees_landmark"] = *t.nees_landmark;
  if (t.modes) {
    out["modes"] = {{"motions", t.modes->motions}};
    out["modes"].update(to_json(static_cast<const DetectionScore&>(*t.modes)));
  }
  if (t.fixes) {
    out["fixes"] = {{"count", t.fixes->fixes},
                    {"false", to_json(t.fixes->wrong)},
                    {"biased", to_json(t.fixes->biased)}};
    if (t.fixes->calibration_error) {
      out["fixes"]["calibration_error"] = *t.fixes->calibration_error;
    }
  }
  return out;
}

/// Estimates that the measurements do not determine become null.
Json to_json(const CalibrationEstimate& calibration) {
  Json out = Json::object();
  for (const CalibrationEstimate::Entry& e : calibration.entries) {
    Json entry = {{"value", nullptr}, {"sigma", nullptr}, {"observed", e.observed}};
    if (e.observed) {
      entry["value"] = e.value;
      entry["sigma"] = e.sigma;
    }
    entry["start"] = e.start;
    if (e.logged) entry["logged"] = *e.logged;
    entry["unit"] = e.unit;
    out[e.name] = entry;
  }
  return out;
}

Json or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json to_json(const NoiseRecord& r) {
  Json out = {{"sensor", r.sensor}, {"kind", r.kind}};
  if (!r.unit.empty()) out["unit"] = r.unit;
  if (r.at_range > 0) out["at_range_m"] = r.at_range;
  out["stated"] = or_null(r.stated);
  out["measured"] = or_null(r.measured);
  out["sigma"] = or_null(r.sigma);
  out["used"] = r.used;
  if (!r.model.empty()) out["used_by_range"] = r.model;
  if (!r.why.empty()) out["not_measured"] = r.why;
  for (const auto& [seconds, factor] : r.growth) {
    out["growth"].push_back({{"seconds", seconds}, {"factor", factor}});
  }
  return out;
}

Json to_json(const AlignmentRecord& r) {
  constexpr double kDegree = M_PI / 180;
  Json out = {{"sensor", r.sensor},
              {"mirrored", r.mirrored},
              {"mirror_sigmas", r.mirror_sigmas},
              {"yaw_deg", r.yaw / kDegree},
              {"yaw_sigma_deg", r.yaw_sigma / kDegree},
              {"delay_s", r.delay},
              {"delay_sigma_s", r.delay_sigma}};
  if (r.length != 1) out["ranges_times"] = r.length;
  if (!r.unknown.empty()) out["unknown"] = r.unknown;
  return out;
}

Json to_json(const FixFigures& fixes) {
  return {{"count", fixes.count},
          {"used", fixes.used},
          {"good", fixes.good},
          {"biased", fixes.biased},
          {"false", fixes.wrong},
          {"bias_runs", fixes.bias_runs},
          {"longest_bias_s", fixes.longest_bias}};
}

/// Quantile `q` of sorted values, interpolated linearly.
double percentile(const std::vector<double>& sorted, double q) {
  const double at = q * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

StepStatistics statistics_of(std::vector<double> ms) {
  StepStatistics s;
  if (ms.empty()) return s;
  std::sort(ms.begin(), ms.end());
  double total_ms = 0;
  for (const double t : ms) total_ms += t;
  s.total_s = 1e-3 * total_ms;
  s.mean_ms = total_ms / static_cast<double>(ms.size());
  s.p50_ms = percentile(ms, 0.50);
  s.p95_ms = percentile(ms, 0.95);
  s.p99_ms = percentile(ms, 0.99);
  s.max_ms = ms.back();
  return s;
}

}  // namespace

StepStatistics step_statistics(const std::vector<StepRecord>& steps) {
  std::vector<double> ms;
  for (const StepRecord& step : steps) ms.push_back(1e3 * step.seconds);
  return statistics_of(std::move(ms));
}

StepStatistics plugin_statistics(const std::vector<StepRecord>& steps) {
  std::vector<double> ms;
  for (const StepRecord& step : steps) ms.push_back(step.plugin_ms);
  return statistics_of(std::move(ms));
}

Json to_json(const std::vector<DrawSummary>& draws) {
  Json out = Json::array();
  for (const DrawSummary& draw : draws) {
    out.push_back({{"settings", draw.settings},
                   {"agreement", draw.agreement},
                   {"health", draw.health ? Json(to_string(*draw.health)) : Json()},
                   {"work", draw.work},
                   {"taken", draw.is_taken}});
  }
  return out;
}

Json summary_json(const Summary& s) {
  Json out = summary_start(s.status, s.message, s.provenance);
  out["mode"] = s.mode;
  out["keyframes"] = s.keyframes;
  out["landmarks"] = s.landmarks;
  out["movers"] = s.movers;
  out["path_m"] = s.path_m;
  out["objective"] = s.objective;
  out["cost"] = s.cost;
  out["solver_s"] = s.solver_s;
  out["total_s"] = s.total_s;
  out["steps"] = to_json(s.steps);
  out["plugins"] = to_json(s.plugins);
  for (const auto& [name, value] : s.statistics) out["plugins"][name] = value;
  if (!s.chosen_plugins.empty()) out["chosen_plugins"] = s.chosen_plugins;
  out["observations"] = Json::object();
  for (const auto& [name, use] : s.observations) {
    out["observations"][name] = {{"count", use.count}, {"used_by", use.users}};
  }
  out["dropped"] = Json::object();
  for (const auto& [reason, count] : s.dropped) out["dropped"][reason] = count;
  out["warnings"] = s.warnings;
  out["health"] = health_json(s.health);
  if (!s.draws.empty()) out["draws"] = to_json(s.draws);
  for (const NoiseRecord& record : s.noise) out["noise"].push_back(to_json(record));
  for (const AlignmentRecord& record : s.alignment) out["alignment"].push_back(to_json(record));
  for (const auto& [mode, count] : s.modes) out["modes"][mode] = count;
  if (s.fixes.count > 0) out["fixes"] = to_json(s.fixes);
  for (const CalibrationEstimate& c : s.calibration) out["calibration"][c.name] = to_json(c);
  const auto localized = [](const std::optional<std::size_t>& at) {
    return at ? Json(*at) : Json();
  };
  if (s.uses_map && s.robots.size() < 2) out["localized_at"] = localized(s.localized_at);
  if (s.truth) out["truth"] = to_json(*s.truth);
  for (const RobotSummary& robot : s.robots) {
    Json entry = {{"name", robot.name}, {"rawlog", robot.rawlog}, {"keyframes", robot.keyframes}};
    if (s.uses_map) entry["localized_at"] = localized(robot.localized_at);
    if (robot.truth) entry["truth"] = to_json(*robot.truth);
    out["robots"].push_back(std::move(entry));
  }
  return out;
}

Json summary_json(const GraphSummary& s) {
  Json out = summary_start(s.status, s.message, s.provenance);
  out["method"] = s.method;
  out["poses"] = s.poses;
  out["landmarks"] = s.landmarks;
  out["solver_s"] = s.solver_s;
  out["total_s"] = s.total_s;
  out["iterations"] = s.iterations;
  out["objective"] = s.objective;
  out["cost"] = s.cost;
  if (s.cost_online) out["cost_online"] = *s.cost_online;
  out["inliers"] = s.inliers;
  out["outliers"] = s.outliers;
  out["unchecked"] = s.unchecked;
  if (s.hypotheses > 0) {
    out["hypotheses"] = s.hypotheses;
    out["first_hypotheses"] = s.first_hypotheses;
  }
  if (!s.note.empty()) out["note"] = s.note;
  if (s.variance_factor) out["variance_factor"] = *s.variance_factor;
  out["health"] = health_json(s.health);
  for (const NoiseRecord& record : s.noise) out["noise"].push_back(to_json(record));
  for (const MemberSummary& member : s.members) {
    out["members"].push_back({{"method", member.method},
                              {"objective", member.objective},
                              {"verified_objective", member.verified_objective},
                              {"inliers", member.accepted},
                              {"seconds", member.seconds}});
  }
  if (!s.start.empty()) out["start"] = s.start;
  for (const StartSummary& start : s.starts) {
    out["starts"].push_back(
        {{"start", start.start}, {"cost", start.cost}, {"iterations", start.iterations}});
  }
  if (s.certificate) {
    out["certificate"] = {{"verified", s.certificate->verified},
                          {"isotropic_verified", s.certificate->isotropic_verified},
                          {"stated_gap", s.certificate->stated_gap},
                          {"min_eigenvalue", s.certificate->min_eigenvalue},
                          {"relative_gap", s.certificate->relative_gap}};
    if (s.certificate->discrete_gap) {
      out["certificate"]["discrete_gap"] = *s.certificate->discrete_gap;
    }
    if (!s.certificate->message.empty()) out["certificate"]["message"] = s.certificate->message;
  }
  if (s.steps) out["steps"] = to_json(*s.steps);
  if (s.truth) out["truth"] = to_json(*s.truth);
  return out;
}

std::string steps_csv(const std::vector<StepRecord>& steps) {
  std::string text =
      "keyframe,time,solver_ms,iterations,flips,relinearized,objective,cost,landmarks,"
      "plugin_ms,eliminated,pending\n";
  for (const StepRecord& s : steps) {
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{},{},{},{},{}\n", s.keyframe,
                   s.time, 1e3 * s.seconds, s.rounds, s.flips, s.relinearized, s.objective_after,
                   s.cost, s.landmarks, s.plugin_ms, s.eliminated, s.pending);
  }
  return text;
}

}  // namespace hybrid
