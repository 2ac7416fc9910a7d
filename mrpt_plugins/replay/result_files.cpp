// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/detail/result_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "libhybrid/io/write_graph.h"
#include "mrpt_plugins/output/figures.h"
#include "mrpt_plugins/output/graph_export.h"
#include "mrpt_plugins/output/landmark_writer.h"
#include "mrpt_plugins/output/map_image.h"
#include "mrpt_plugins/output/mode_writer.h"
#include "mrpt_plugins/output/scene.h"
#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/output/trajectory_writer.h"

namespace hybrid {

std::vector<std::string> write_texts(const OutputDirectory& out, const MapResult& result,
                                     const Backend& backend) {
  out.write("trajectory.tum", tum_text(result.trajectory));
  out.write("trajectory_dead_reckoning.tum", tum_text(result.dead_reckoning));
  out.write("landmarks.csv", landmarks_csv(result));
  out.write("landmarks.json", landmarks_json(result));
  out.write("steps.csv", steps_csv(result.steps));
  if (!result.mode_names.empty()) out.write("modes.csv", modes_csv(result));
  const ExportedGraph graph =
      export_graph(backend.graph(), {backend.values(), backend.assignment()});
  out.write("graph.g2o", to_g2o(graph.graph));
  if (graph.left_out.empty()) return {};
  return {fmt::format("graph.g2o lacks factors that have no such form: {}",
                      fmt::join(graph.left_out, ", "))};
}

void write_true_path(const OutputDirectory& out, const MapResult& result, const Truth& truth,
                     const std::vector<std::size_t>& log_rows) {
  if (truth.get().path.empty()) return;
  const Truth::Pairs pairs = truth.pairs(result.trajectory, log_rows);
  Trajectory path;
  for (std::size_t i = 0; i < pairs.times.size(); ++i) {
    path.push_back({pairs.times[i], pairs.poses[i].truth});
  }
  out.write("trajectory_truth.tum", tum_text(path));
}

std::vector<std::string> write_pictures(const OutputDirectory& out, const MapResult& result,
                                        const GroundTruth& truth) {
  std::vector<std::string> warnings;
  out.write("map.png", png(map_image(result, truth)));
  const Map3dImage view = map_3d_image(result, truth);
  if (!view.warning.empty()) warnings.push_back(view.warning);
  out.write("map_3d.png", png(view.image));
  save_scene(out, "scene.3Dscene", result, truth);
  out.write("steps.png", png(steps_image(result.steps, result.title)));
  return warnings;
}

void write_error_plot(const OutputDirectory& out, const MapResult& result, const Truth& truth,
                      const std::vector<std::size_t>& log_rows) {
  if (truth.get().path.empty()) return;
  const Truth::Pairs estimate = truth.pairs(result.trajectory, log_rows);
  const Truth::Pairs reckoned = truth.pairs(result.dead_reckoning, log_rows);
  out.write("error.png",
            png(error_image(estimate.times, estimate.poses, reckoned.poses, result.title)));
}

}  // namespace hybrid
