// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-objects/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/exit_code.h"
#include "apps/hybrid-objects/quaternion_order.h"
#include "apps/program.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/io/folders.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/drawing/plot.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kOurs = 1;  // index of our method in the answers

double mean(const std::vector<double>& errors) {
  double sum = 0.0;
  int count = 0;
  for (double e : errors) {
    if (std::isnan(e)) continue;
    sum += e;
    ++count;
  }
  return count == 0 ? std::nan("") : sum / count;
}

std::size_t accepted(const RobustResult& result) {
  return std::count_if(result.decisions.begin(), result.decisions.end(),
                       [](const ClosureDecision& decision) { return decision.accepted(); });
}

std::string objects_csv(const ObjectReport& report) {
  std::string csv = "object,method,x,y,z,qx,qy,qz,qw,error_m,error_deg\n";
  for (std::size_t k = 0; k < report.sequence.objects.size(); ++k) {
    for (const ObjectReport::Answer& answer : report.answers) {
      if (!answer.result.values.contains(object_key(k))) continue;
      csv += report.sequence.objects[k].name + "," + answer.result.method;
      const double* x = answer.result.values.data(object_key(k));
      for (int i = 0; i < SE3::kSize; ++i) csv += fmt::format(",{:.9g}", x[i]);
      const bool known = answer.errors && !std::isnan(answer.errors->object_m[k]);
      csv += known ? fmt::format(",{:.6g},{:.6g}\n", answer.errors->object_m[k],
                                 answer.errors->object_deg[k])
                   : ",,\n";
    }
  }
  return csv;
}

std::string trajectory_tum(const ObjectReport& report) {
  std::string text = "# timestamp tx ty tz qx qy qz qw\n";
  for (std::size_t i = 0; i < report.sequence.times.size(); ++i) {
    text += fmt::format("{}", report.sequence.times[i]);
    const double* x = report.answers[kOurs].result.values.data(camera_key(i));
    for (int j = 0; j < SE3::kSize; ++j) text += fmt::format(" {:.9g}", x[j]);
    text += "\n";
  }
  return text;
}

/// One row for each kind of noise: stated, measured (null where it was not) and used.
Json noise_json(const ObjectReport& report) {
  Json rows = Json::array();
  const auto add = [&](const std::string& of, const char* kind, const char* unit, bool measured,
                       double stated, double used) {
    Json row = {{"of", of}, {"kind", kind}, {"unit", unit}, {"stated", stated}};
    row["measured"] = measured ? Json(used) : Json(nullptr);
    row["used"] = used;
    rows.push_back(row);
  };
  const ObjectNoise &stated = report.stated, &used = report.noise;
  add("odometry", "translation", "m", used.odometry_measured, stated.step_m, used.step_m);
  add("odometry", "rotation", "rad", used.odometry_measured, stated.step_rad, used.step_rad);
  for (std::size_t k = 0; k < used.sightings.size(); ++k) {
    const std::string& name = report.sequence.objects[k].name;
    const SightingNoise &was = stated.sightings[k], &is = used.sightings[k];
    const bool measured = used.sightings_measured[k];
    add(name, "across", "m", measured, was.across_m, is.across_m);
    add(name, "along", "m", measured, was.along_m, is.along_m);
    add(name, "angle", "rad", measured, was.angle_rad, is.angle_rad);
    add(name, "repetitions", "", measured, was.repetitions, is.repetitions);
  }
  return rows;
}

Json summary_json(const ObjectReport& report) {
  Json json;
  json["sequence"] = report.name;
  json["frames"] = report.sequence.times.size();
  json["detections"] = report.problem.closures.size();
  json["noise"] = noise_json(report);
  for (const ObjectReport::Answer& answer : report.answers) {
    Json entry;
    entry["method"] = answer.result.method;
    entry["status"] = answer.result.converged ? "ok" : "not converged";
    entry["solver_s"] = answer.result.seconds;
    entry["inliers"] = accepted(answer.result);
    if (answer.errors) {
      entry["ate_rmse_m"] = answer.errors->trajectory_m;
      entry["object_mean_m"] = mean(answer.errors->object_m);
      entry["object_mean_deg"] = mean(answer.errors->object_deg);
    }
    json["methods"].push_back(entry);
  }
  return json;
}

/// Adds a point in the view from above: x and z of the first camera.
void add(Series& series, const Eigen::Vector3d& point) {
  series.x.push_back(point.x());
  series.y.push_back(point.z());
}

Series markers(const std::string& label, Color color, Marker marker, double radius) {
  Series series;
  series.label = label;
  series.color = color;
  series.line = LineStyle::kNone;
  series.marker = marker;
  series.marker_radius = radius;
  return series;
}

std::vector<Series> detection_series(const ObjectReport& report) {
  Series in = markers("detections accepted", palette::kUnclassed, Marker::kCircle, 2);
  Series out = markers("detections rejected", palette::kDeadReckoning, Marker::kCross, 3);
  const RobustResult& ours = report.answers[kOurs].result;
  for (std::size_t c = 0; c < report.problem.closures.size(); ++c) {
    const auto& sighting = dynamic_cast<const Between<SE3>&>(*report.problem.closures[c]);
    const SE3 seen = ours.values.at<SE3>(sighting.keys()[0]) * sighting.measured();
    add(ours.decisions[c].accepted() ? in : out, seen.translation());
  }
  return {out, in};
}

PlotSpec picture(const ObjectReport& report) {
  PlotSpec spec;
  spec.title = "Objects of sequence " + report.name + ", from above the first camera";
  spec.x.label = "x, to the right of the first camera (m)";
  spec.y.label = "z, ahead of the first camera (m)";
  spec.equal_aspect = true;
  spec.width = 1300;
  spec.series = detection_series(report);
  const ObjectReport::Answer& ours = report.answers[kOurs];
  Series path;
  path.label = "camera";
  for (std::size_t i = 0; i < report.sequence.times.size(); ++i) {
    add(path, ours.result.values.at<SE3>(camera_key(i)).translation());
  }
  if (ours.errors) {
    spec.subtitle = fmt::format("Camera off by {:.4f} m (RMSE), objects by {:.4f} m (mean)",
                                ours.errors->trajectory_m, mean(ours.errors->object_m));
    const SE3 T_map_world = ours.errors->T_world_map.inverse();
    Series truth;
    truth.label = "camera, true";
    truth.color = palette::kTruth;
    truth.width = 5;
    for (const SE3& pose : report.sequence.truth) add(truth, T_map_world * pose.translation());
    spec.series.push_back(truth);
    spec.series.push_back(path);
    Series objects = markers("objects, true", palette::kBlack, Marker::kPlus, 14);
    for (const auto& object : ours.errors->objects) {
      if (object) add(objects, T_map_world * object->translation());
    }
    spec.series.push_back(objects);
  } else {
    spec.series.push_back(path);
  }
  const std::vector<std::pair<const char*, Marker>> methods = {{"", Marker::kNone},
                                                               {"switches", Marker::kStar},
                                                               {"Huber", Marker::kSquare},
                                                               {"Cauchy", Marker::kTriangle}};
  for (std::size_t m = kOurs; m < methods.size(); ++m) {
    Series objects =
        markers(std::string("objects, ") + methods[m].first, series_color(m), methods[m].second, 8);
    for (std::size_t k = 0; k < report.sequence.objects.size(); ++k) {
      const Values& values = report.answers[m].result.values;
      if (values.contains(object_key(k))) add(objects, values.at<SE3>(object_key(k)).translation());
    }
    spec.series.push_back(objects);
  }
  return spec;
}

}  // namespace

ObjectReport solve_sequence(const std::string& name, const std::string& folder, bool measured) {
  ObjectReport report;
  report.name = name;
  report.sequence = read_object_sequence(folder);
  report.stated = stated_noise(report.sequence);
  report.noise = measured ? measure_noise(report.sequence, report.stated) : report.stated;
  report.problem = object_problem(report.sequence, report.noise);
  RobustResult start;
  start.method = "start";
  start.values = report.problem.initial;
  std::vector<RobustResult> results = {
      start, count_repetitions(report.sequence, report.noise, solve_objects(report.problem)),
      solve_objects(report.problem, Loss::huber()), solve_objects(report.problem, Loss::cauchy())};
  for (RobustResult& result : results) {
    ObjectReport::Answer answer;
    if (!report.sequence.truth.empty()) {
      answer.errors = object_map_errors(report.sequence, result.values);
    }
    answer.result = std::move(result);
    report.answers.push_back(std::move(answer));
  }
  return report;
}

std::string comparison_table(const std::vector<ObjectReport>& reports) {
  std::string table = fmt::format("{:<12} {:<9} {:>9} {:>9} {:>9} {:>11} {:>8}\n", "sequence",
                                  "method", "camera m", "object m", "deg", "accepted", "s");
  for (const ObjectReport& report : reports) {
    for (const ObjectReport::Answer& answer : report.answers) {
      table += fmt::format("{:<12} {:<9} ", report.name, answer.result.method);
      table += answer.errors
                   ? fmt::format("{:>9.4f} {:>9.4f} {:>9.2f}", answer.errors->trajectory_m,
                                 mean(answer.errors->object_m), mean(answer.errors->object_deg))
                   : fmt::format("{:>9} {:>9} {:>9}", "-", "-", "-");
      table += fmt::format(" {:>5}/{:<5} {:>8.2f}\n", accepted(answer.result),
                           report.problem.closures.size(), answer.result.seconds);
    }
  }
  return table;
}

std::string noise_lines(const std::vector<ObjectReport>& reports) {
  std::string text;
  for (const ObjectReport& report : reports) {
    const ObjectNoise& noise = report.noise;
    text += fmt::format("{}: odometry {:.2g} m, {:.2g} rad a frame ({})", report.name, noise.step_m,
                        noise.step_rad, noise.odometry_measured ? "measured" : "stated");
    for (std::size_t k = 0; k < noise.sightings.size(); ++k) {
      const SightingNoise& s = noise.sightings[k];
      text += fmt::format(
          "; {} {:.2g} m across, {:.2g} m along, {:.2g} rad, {:.3g} times repeated ({})",
          report.sequence.objects[k].name, s.across_m, s.along_m, s.angle_rad, s.repetitions,
          noise.sightings_measured[k] ? "measured" : "stated");
    }
    text += "\n";
  }
  return text;
}

void add_sequence(const std::string& folder, Provenance& provenance) {
  for (const FolderEntry& entry : entries_of(folder)) {
    const std::string& name = entry.name;
    const bool read = name == "odom.txt" || name == "cam_gt.txt" || name.rfind("det_", 0) == 0 ||
                      name.rfind("objgt_", 0) == 0;
    const std::filesystem::path path = std::filesystem::path(folder) / name;
    if (read && std::filesystem::is_regular_file(path)) provenance.add_input(path.string());
  }
}

int write_reports(const std::vector<ObjectReport>& reports, const std::filesystem::path& output,
                  const Provenance& provenance) {
  OutputDirectory out(output);
  Json sequences = Json::array();
  std::string astray;
  for (const ObjectReport& report : reports) {
    out.write(report.name + "/objects.csv", objects_csv(report));
    out.write(report.name + "/trajectory.tum", trajectory_tum(report));
    out.write(report.name + "/objects.png", png(render(picture(report))));
    sequences.push_back(summary_json(report));
    if (!report.answers[kOurs].result.converged) {
      astray += (astray.empty() ? "" : ", ") + report.name;
    }
  }
  const std::string message = astray.empty() ? "" : "the solver did not converge on " + astray;
  Json summary = summary_start(astray.empty() ? "ok" : "partial", message, provenance);
  summary["sequences"] = std::move(sequences);
  const std::vector<std::string> told = out.publish(std::move(summary));
  const int code = settle(astray.empty() ? kExitOk : kExitPartial);
  for (const ObjectReport& report : reports) {
    if (seems_real_part_first(report.sequence)) {
      complain(
          "hybrid-objects: {}/odom.txt: read as qx qy qz qw the objects move about; is qw first? "
          "With the real part first they would stay in place\n",
          report.name);
    }
    if (!report.sequence.truth.empty()) continue;
    complain("hybrid-objects: {}: no cam_gt.txt, so there are no errors to tell\n", report.name);
  }
  for (const std::string& text : told) complain("hybrid-objects: {}\n", text);
  if (!message.empty()) complain("hybrid-objects: {}\n", message);
  return code;
}

}  // namespace hybrid
