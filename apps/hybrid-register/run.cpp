// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-register/run.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/exit_code.h"
#include "apps/hybrid-register/transform_file.h"
#include "apps/program.h"
#include "libhybrid/core/error.h"
#include "libhybrid/registration/register.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/input/point_maps.h"
#include "mrpt_plugins/output/overlay_image.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

Points read_input(const std::string& path) {
  PointFile file = read_point_source(path);
  if (file.left_out > 0) {
    complain("hybrid-register: {}: {} points that are not finite were left out\n", path,
             file.left_out);
  }
  if (file.points.size() < 3) {
    throw Error(fmt::format("{}: holds {} points; a registration needs at least 3", path,
                            file.points.size()));
  }
  return std::move(file.points);
}

const char* shape_name(LocalShape shape) {
  if (shape == LocalShape::kSurface) return "surface";
  return shape == LocalShape::kCurve ? "curve" : "point";
}

std::string free_text(const RegistrationResult& result) {
  std::string text;
  for (const FreeMotion& motion : result.free_motions) {
    text += (text.empty() ? "" : "; ") + to_string(motion);
  }
  return text;
}

Json stages_json(const RegistrationResult& result) {
  Json stages = Json::array();
  for (const RegistrationStage& stage : result.stages) {
    stages.push_back({{"source_points", stage.source_points},
                      {"target_points", stage.target_points},
                      {"noise_across", stage.noise.across},
                      {"noise_along", stage.noise.along},
                      {"inliers", stage.inliers},
                      {"objectives", stage.objectives}});
  }
  return stages;
}

Json summary_json(const RegistrationResult& result, const Provenance& provenance,
                  std::size_t source_points, std::size_t target_points) {
  const bool determined = result.free_motions.empty();
  Json json = summary_start(determined ? "ok" : "unobservable", "", provenance);
  json["solver_s"] = result.seconds;
  json["iterations"] = result.iterations;
  json["starts"] = result.starts;
  json["rms"] = result.rms;
  json["rms_across"] = result.rms_across;
  json["inlier_fraction"] = result.inliers / static_cast<double>(source_points);
  json["inliers"] = result.inliers;
  json["source_points"] = source_points;
  json["target_points"] = target_points;
  json["objective"] = result.objective;
  json["metric"] = shape_name(result.shape);
  json["noise"] = {{"across", result.noise.across}, {"along", result.noise.along}};
  Json free = Json::array();
  for (const FreeMotion& motion : result.free_motions) free.push_back(to_string(motion));
  json["unobservable"] = free;
  // Tangent covariance of the transform: translation, then rotation vector [rad], in the axes of
  // the source.
  json["covariance"] = nullptr;
  if (determined) {
    Json rows = Json::array();
    for (int i = 0; i < 6; ++i) {
      rows.push_back(
          std::vector<double>(result.covariance.col(i).begin(), result.covariance.col(i).end()));
    }
    json["covariance"] = rows;
  }
  json["stages"] = stages_json(result);
  return json;
}

double angle_deg(const SE3& T) {
  return T.rotation().log().norm() * 180.0 / M_PI;
}

Overlay overlay_of(const Options& options, const RegistrationResult& result, const SE3& start,
                   Points source, Points target) {
  const auto name = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  Overlay overlay;
  overlay.title =
      fmt::format("Registration of {} to {}", name(options.source), name(options.target));
  const std::string unit = options.unit.empty() ? "" : " " + options.unit;
  overlay.note = fmt::format(
      "Turned by {:.4g} degrees, moved by {:.4g}{}; {:.1f} % of the source matched, rms {:.3g}{}",
      angle_deg(result.T_target_source), result.T_target_source.translation().norm(), unit,
      100.0 * result.inliers / static_cast<double>(source.size()), result.rms, unit);
  overlay.source = std::move(source);
  overlay.target = std::move(target);
  overlay.before = start;
  overlay.after = result.T_target_source;
  overlay.unit = options.unit.empty() ? "unit of the files" : options.unit;
  return overlay;
}

Provenance provenance(const Options& options) {
  Provenance provenance = options.provenance;
  for (const std::string& path : {options.source, options.target, options.start}) {
    // LOG.rawlog#N names a step of LOG.rawlog.
    provenance.add_input(std::filesystem::exists(path) ? path : path.substr(0, path.rfind('#')));
  }
  warn_of_inputs(provenance);
  return provenance;
}

}  // namespace

int run(const Options& options) {
  RegistrationOptions settings;
  settings.metric = options.metric == "point" ? MatchMetric::kPoint : MatchMetric::kSurface;
  settings.threads = options.threads;
  if (!options.search) settings.convincing_share = 0.0;
  if (!options.start.empty()) settings.start = read_transform(options.start);
  Points source = read_input(options.source), target = read_input(options.target);
  const RegistrationResult result = about({options.source + " onto " + options.target}, [&] {
    return register_clouds(source, target, settings);
  });
  if (result.status == RegistrationResult::Status::kNoMatch) {
    throw Error(fmt::format(
        "no counterparts found: {} and {} do not overlap, or the start is too far away; give a "
        "better one with --start",
        options.source, options.target));
  }
  OutputDirectory out(options.output);
  Json summary = summary_json(result, provenance(options), source.size(), target.size());
  const std::string told =
      fmt::format("{} of {} points matched, rms {:.6g}, turned by {:.6g} degrees, {:.3f} s -> {}\n",
                  result.inliers, source.size(), result.rms, angle_deg(result.T_target_source),
                  result.seconds, out.folder().string());
  out.write("transform.txt", transform_text(result.T_target_source));
  const Overlay overlay =
      overlay_of(options, result, settings.start, std::move(source), std::move(target));
  out.write("overlay.png", png(overlay_image(overlay)));
  const std::vector<std::string> moved = out.publish(std::move(summary));
  const int code = settle(result.free_motions.empty() ? kExitOk : kExitPartial);
  for (const std::string& text : moved) complain("hybrid-register: {}\n", text);
  say("{}", told);
  if (code != kExitOk) {
    complain("hybrid-register: the matches do not determine: {}\n", free_text(result));
  }
  return code;
}

}  // namespace hybrid
