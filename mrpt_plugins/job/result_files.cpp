// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/detail/result_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <optional>

#include "libhybrid/io/write_graph.h"
#include "mrpt_plugins/bridge/geodesy.h"
#include "mrpt_plugins/map_file/export_map.h"
#include "mrpt_plugins/output/figures.h"
#include "mrpt_plugins/output/fix_writer.h"
#include "mrpt_plugins/output/graph_export.h"
#include "mrpt_plugins/output/landmark_writer.h"
#include "mrpt_plugins/output/map_image.h"
#include "mrpt_plugins/output/mode_writer.h"
#include "mrpt_plugins/output/mover_writer.h"
#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/output/trajectory_writer.h"

namespace hybrid {

namespace {

/// Where a file of a robot stands.
std::string file_of(const RobotPart& part, const std::string& name) {
  return part.name.empty() ? name : part.name + "/" + name;
}

/// How far two places of a map may be from each other and count as one: what a person reads off a
/// map, beside errors of receivers.
constexpr double kSamePlace = 10, kSameDirection = 3;  // m, deg

/// How two places of the origin of a map differ; empty where they hardly do.
std::vector<std::string> conflict(const MapOrigin& given, const MapOrigin& by_fixes) {
  const Eigen::Vector3d apart = LocalFrame({given.latitude, given.longitude})
                                    .to_local({by_fixes.latitude, by_fixes.longitude});
  const double turn = std::remainder(by_fixes.direction - given.direction, 360.0);
  if (apart.head<2>().norm() < kSamePlace && std::abs(turn) < kSameDirection) return {};
  return {fmt::format(
      "map.geojson is by [map] origin; by the fixes the origin of the map is {:.3g} m from there, "
      "and its x axis turned by {:.2g} deg",
      apart.head<2>().norm(), turn)};
}

}  // namespace

std::vector<std::string> write_globe(const OutputDirectory& out, const MapResult& result,
                                     const std::optional<MapOrigin>& given) {
  std::optional<MapOrigin> by_fixes;
  if (result.datum && result.datum->is_on_earth) by_fixes = origin_of(*result.datum);
  if (!given && !by_fixes) {
    if (!result.datum) return {};
    return {"no map.geojson: the fixes of the log are in local axes, not on earth"};
  }
  const MapOrigin& origin = given ? *given : *by_fixes;
  out.write("map.geojson", geojson_text(result, origin));
  return given && by_fixes ? conflict(origin, *by_fixes) : std::vector<std::string>();
}

std::vector<std::string> write_map(const OutputDirectory& out, const MapResult& result,
                                   const Backend& backend) {
  out.write("landmarks.csv", landmarks_csv(result));
  out.write("landmarks.json", landmarks_json(result));
  if (!result.movers.empty()) out.write("movers.csv", movers_csv(result));
  if (!result.fixes.empty()) out.write("fixes.csv", fixes_csv(result));
  out.write("steps.csv", steps_csv(result.steps));
  const ExportedGraph graph =
      export_graph(backend.graph(), {backend.values(), backend.assignment()});
  out.write("graph.g2o", to_g2o(graph.graph));
  if (graph.left_out.empty()) return {};
  return {fmt::format("graph.g2o lacks factors that have no such form: {}",
                      fmt::join(graph.left_out, ", "))};
}

void write_paths(const OutputDirectory& out, const std::vector<RobotPart>& parts,
                 const PathArchive& paths, const MapResult& whole,
                 const std::vector<Truth>& truths) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const RobotPart& part = parts[i];
    out.write(file_of(part, "trajectory.tum"), tum_text(paths.path(whole.trajectory, i)));
    out.write(file_of(part, "trajectory_dead_reckoning.tum"),
              tum_text(paths.reckoned_path(whole.dead_reckoning, i)));
    if (!part.result.mode_names.empty()) {
      out.write(file_of(part, "modes.csv"), modes_csv(part.result));
    }
    if (truths[i].get().path.empty() || part.result.trajectory.empty()) continue;
    const Truth::Pairs pairs = truths[i].pairs(part.result.trajectory, part.log_rows);
    Trajectory path;
    for (std::size_t k = 0; k < pairs.times.size(); ++k) {
      path.push_back({pairs.times[k], pairs.poses[k].truth});
    }
    out.write(file_of(part, "trajectory_truth.tum"), tum_text(path));
  }
}

void write_covariances(const OutputDirectory& out, const std::vector<RobotPart>& parts) {
  for (const RobotPart& part : parts) {
    out.write(file_of(part, "trajectory_covariances.csv"),
              covariances_csv(part.result.trajectory, part.covariances, part.result.is_3d));
  }
}

void write_pictures(const OutputDirectory& out, PictureFormat format, const MapResult& result,
                    const GroundTruth& truth) {
  out.write("map" + ending(format), encoded(map_image(result, truth), format));
  out.write("steps" + ending(format), encoded(steps_image(result.steps, result.title), format));
}

void write_error_plots(const OutputDirectory& out, PictureFormat format,
                       const std::vector<RobotPart>& parts, const std::vector<Truth>& truths) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const RobotPart& part = parts[i];
    if (truths[i].get().path.empty() || part.result.trajectory.empty()) continue;
    const Truth::Pairs estimate = truths[i].pairs(part.result.trajectory, part.log_rows);
    const Truth::Pairs reckoned = truths[i].pairs(part.result.dead_reckoning, part.log_rows);
    const std::string title =
        part.name.empty() ? part.result.title : part.result.title + ", robot " + part.name;
    out.write(file_of(part, "error" + ending(format)),
              encoded(error_image(estimate.times, estimate.poses, reckoned.poses, title), format));
  }
}

}  // namespace hybrid
