// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-pgo/outputs.h"

#include <fmt/format.h>

#include <iterator>
#include <unordered_map>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/io/write_graph.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/pose_graph/vertex_id.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/evaluation/graph_truth.h"
#include "mrpt_plugins/output/closure_csv.h"
#include "mrpt_plugins/output/graph_image.h"

namespace hybrid {
namespace {

/// Calls visit(from, to, factor, is_odometry) for every relative pose.
template <class Visit>
void for_each_relative_pose(const Input& input, const Visit& visit) {
  const std::size_t count = input.graph.poses2.size() + input.graph.poses3.size();
  for (std::size_t f = 0; f < count; ++f) {
    const ContinuousFactor& factor = *input.factors[f];
    const Key from = factor.keys()[0], to = factor.keys()[1];
    visit(from, to, factor, !input.is_closure[f]);
  }
}

/// Position of a pose or landmark (m), z = 0 in the plane.
Eigen::Vector3d position(const Values& values, Key key) {
  const double* x = values.data(key);
  const VariableType type = values.type(key);
  const bool in_space = type == Variable<SE3>::type() || type == Variable<Eigen::Vector3d>::type();
  return {x[0], x[1], in_space ? x[2] : 0.0};
}

}  // namespace

std::vector<Loop> find_loops(const Input& input, const Values& estimate,
                             const std::map<std::size_t, ClosureDecision>& decisions) {
  std::vector<Loop> loops;
  std::size_t number = 0;
  for_each_relative_pose(input,
                         [&](Key from, Key to, const ContinuousFactor& factor, bool is_odometry) {
                           const std::size_t f = number++;
                           const auto decision = decisions.find(f);
                           if (is_odometry) return;
                           loops.push_back({from, to, f});
                           if (decision != decisions.end())
                             loops.back().decision = decision->second;
                           loops.back().decision.chi_square = 2 * factor.cost(estimate);
                         });
  const std::size_t first = input.graph.edge_count();
  for (std::size_t f = first; f < first + input.graph.prior_count(); ++f) {
    const Key pose = input.factors[f]->keys()[0];
    loops.push_back({pose, pose, f});
    const auto decision = decisions.find(f);
    if (decision != decisions.end()) loops.back().decision = decision->second;
    loops.back().decision.chi_square = 2 * input.factors[f]->cost(estimate);
  }
  return loops;
}

std::vector<const Loop*> loops_of_factors(const Input& input, const std::vector<Loop>& loops) {
  std::vector<const Loop*> out(input.factors.size(), nullptr);
  for (const Loop& loop : loops) out.at(loop.factor) = &loop;
  return out;
}

std::string hypotheses_csv(const Input& input, const std::vector<int>& chosen) {
  std::string text = "i,j,hypothesis,first\n";
  const PoseGraph& graph = input.graph;
  std::size_t k = 0;
  const auto add = [&](const auto& edge) {
    fmt::format_to(std::back_inserter(text), "{},{},{},{}\n", vertex_id(edge.from.index()),
                   vertex_id(edge.to.index()), chosen[k], input.first_hypotheses[k]);
    ++k;
  };
  for (const auto& alternatives : graph.alternatives2) add(graph.poses2[alternatives.edge]);
  for (const auto& alternatives : graph.alternatives3) add(graph.poses3[alternatives.edge]);
  return text;
}

std::string loops_csv(const std::vector<Loop>& loops) {
  std::string text = fmt::format("i,j,{}\n", kDecisionColumns);
  for (const Loop& loop : loops) {
    fmt::format_to(std::back_inserter(text), "{},{},{}\n", vertex_id(loop.from.index()),
                   vertex_id(loop.to.index()), decision_cells(loop.decision));
  }
  return text;
}

void write_graph(const OutputDirectory& out, const Input& input, const Values& estimate) {
  PoseGraph graph = input.graph;
  graph.values = Values();
  for (Key key : input.initial.keys()) {
    graph.values.insert(key, estimate.type(key), estimate.data(key));
  }
  out.write("graph.g2o", to_g2o(graph));
}

std::vector<std::string> ids_of(const std::vector<Key>& poses, const Values& values) {
  std::vector<std::string> ids;
  for (const Key key : poses) {
    if (values.contains(key)) ids.push_back(std::to_string(vertex_id(key.index())));
  }
  return ids;
}

Trajectory trajectory_of(const std::vector<Key>& poses, const Values& values) {
  Trajectory path;
  for (const Key key : poses) {
    if (values.contains(key))
      path.push_back({static_cast<double>(key.index()), pose_at(values, key)});
  }
  return path;
}

namespace {

/// The drawing without loop closures and truth.
GraphDrawing drawing_of(const std::string& title, const Input& input, const Values& values) {
  GraphDrawing drawing;
  drawing.title = "Pose graph " + title;
  drawing.is_3d = input.is_3d();
  for (Key key : input.poses()) drawing.poses.push_back(position(values, key));
  for (Key key : values.keys()) {
    if (key.letter() == key_letter::kLandmark) drawing.landmarks.push_back(position(values, key));
  }
  for_each_relative_pose(input, [&](Key from, Key to, const ContinuousFactor&, bool is_odometry) {
    if (!is_odometry) return;
    drawing.odometry.emplace_back(position(values, from), position(values, to));
  });
  return drawing;
}

GraphDrawing drawing_of_start(const std::string& title, const Input& input) {
  GraphDrawing drawing = drawing_of(title, input, input.initial);
  drawing.subtitle = "Before optimisation, where the solver starts";
  for_each_relative_pose(input, [&](Key from, Key to, const ContinuousFactor&, bool is_odometry) {
    if (is_odometry) return;
    drawing.closures.emplace_back(position(input.initial, from), position(input.initial, to));
  });
  return drawing;
}

}  // namespace

void draw_graph(const OutputDirectory& out, PictureFormat format, const std::string& title,
                const Input& input, const Solution& solution, const std::vector<Loop>& loops,
                const std::vector<PosePair>& truth) {
  const Values& values = solution.values;
  GraphDrawing drawing = drawing_of(title, input, values);
  drawing.subtitle = fmt::format("After optimisation ({}): cost {:.6g}",
                                 solution.steps.empty() ? "batch" : "online", solution.cost);
  for (const Loop& loop : loops) {
    if (loop.in_map()) continue;
    (loop.decision.in_force() ? drawing.closures : drawing.rejected)
        .emplace_back(position(values, loop.from), position(values, loop.to));
  }
  for (const PosePair& pair : truth) {
    drawing.truth.emplace_back(pair.truth.x(), pair.truth.y(), pair.truth.z());
  }
  const auto write = [&](const std::string& name, const Image& image) {
    out.write(name + ending(format), encoded(image, format));
  };
  write("graph_start", graph_image(drawing_of_start(title, input)));
  write("graph", graph_image(drawing));
}

GraphReport graph_report(const std::string& title, const Input& input, const Solution& solution,
                         const std::vector<Loop>& loops, const std::vector<PosePair>& truth) {
  GraphReport report;
  report.title = title;
  report.is_3d = input.is_3d();
  const Values& values = solution.values;
  std::unordered_map<Key, std::size_t> place;
  for (const Key key : input.poses()) {
    if (!values.contains(key)) continue;
    place[key] = report.ids.size();
    report.ids.push_back(vertex_id(key.index()));
    report.before.push_back(position(input.initial, key));
    report.after.push_back(position(values, key));
  }
  for (const Key key : values.keys()) {
    if (key.letter() == key_letter::kLandmark) report.landmarks.push_back(position(values, key));
  }
  for_each_relative_pose(input, [&](Key from, Key to, const ContinuousFactor&, bool is_odometry) {
    if (is_odometry) report.edges.emplace_back(place.at(from), place.at(to));
  });
  for (const Loop& loop : loops) {
    if (loop.in_map()) continue;
    report.closures.push_back({place.at(loop.from), place.at(loop.to), loop.decision});
  }
  for (const PosePair& pair : truth) {
    report.truth.emplace_back(pair.truth.x(), pair.truth.y(), pair.truth.z());
  }
  report.objectives = solution.objectives;
  for (const StepRecord& step : solution.steps) {
    if (solution.objectives.empty()) report.objectives.push_back(step.objective_after);
  }
  report.steps = solution.steps;
  return report;
}

}  // namespace hybrid
