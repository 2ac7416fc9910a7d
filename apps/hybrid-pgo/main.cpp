// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/exit_code.h"
#include "apps/hybrid-pgo/certify.h"
#include "apps/hybrid-pgo/fixed.h"
#include "apps/hybrid-pgo/noise.h"
#include "apps/hybrid-pgo/options.h"
#include "apps/hybrid-pgo/outputs.h"
#include "apps/hybrid-pgo/robust.h"
#include "apps/hybrid-pgo/solution.h"
#include "apps/hybrid-pgo/stopped.h"
#include "apps/program.h"
#include "libhybrid/core/error.h"
#include "libhybrid/pose_graph/vertex_id.h"
#include "libhybrid/selection/closure_agreement.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/evaluation/graph_truth.h"
#include "mrpt_plugins/health/agreement.h"
#include "mrpt_plugins/health/closures.h"
#include "mrpt_plugins/health/health.h"
#include "mrpt_plugins/health/health_lines.h"
#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/output/trajectory_writer.h"
#include "mrpt_plugins/report/page.h"

namespace hybrid {
namespace {

constexpr double kMostScatter = 2;  // beyond it, the noise itself is bad

/// What residuals of closures may be in units of what their information says.
double scatter_of_closures(const std::vector<NoiseRecord>& noise) {
  for (const NoiseRecord& record : noise) {
    if (record.kind == "closures" && record.measured) {
      return std::clamp(*record.measured, 1.0, kMostScatter);
    }
  }
  return 1;
}

/// Whether closures that were measured at different times agree with the path. `noise` has the
/// scatter of the closures, where it was measured. Empty where there are no closures, or more
/// variables than those whose covariances take seconds.
Health graph_agreement(const Input& input, const Solution& solution, const std::vector<Loop>& loops,
                       const std::vector<NoiseRecord>& noise) {
  if (solution.values.size() > kMostWithCovariances || !input.first_hypotheses.empty()) return {};
  const std::vector<const Loop*> loop_of = loops_of_factors(input, loops);
  RobustProblem problem;
  std::vector<bool> accepted;
  for (std::size_t f = 0; f < input.factors.size(); ++f) {
    const Loop* loop = loop_of[f];
    const bool in_force = loop == nullptr || loop->decision.in_force();
    if (loop != nullptr && !loop->in_map()) {
      problem.closures.push_back(input.factors[f]);
      accepted.push_back(in_force);
    } else if (in_force) {
      problem.trusted.push_back(input.factors[f]);
    }
  }
  if (accepted.empty()) return {};
  const ClosureAgreement found =
      agreement_of_closures(problem, solution.values, accepted, scatter_of_closures(noise));
  std::string rival;
  if (!found.rival_closures.empty()) {
    const std::vector<Key>& keys = problem.closures[found.rival_closures.front()]->keys();
    rival = fmt::format("{} {}", vertex_name(keys[0].index()), vertex_name(keys[1].index()));
  }
  return {closure_agreement_health(found, rival)};
}

using Clock = std::chrono::steady_clock;

/// What is guessed or left out.
std::string notes_on(const Input& input) {
  const PoseGraph& graph = input.graph;
  std::string notes;
  const auto note = [&](const std::string& text) { notes += (notes.empty() ? "" : "; ") + text; };
  if (graph.equivalences > 0) {
    note(fmt::format("{} EQUIV lines of the graph are not applied", graph.equivalences));
  }
  if (graph.repaired > 0) {
    note(fmt::format("{} information matrices were not positive definite: repaired",
                     graph.repaired));
  }
  if (graph.edge2_by_rows) {
    note(
        "information of EDGE2 is not positive definite in TORO's order: read row by row, as iSAM "
        "writes it");
  }
  if (graph.copies > 0) {
    note(fmt::format("{} edges are the same as one before: they count once", graph.copies));
  }
  if (graph.unseen > 0) {
    note(fmt::format("{} landmarks that nothing measures are left out", graph.unseen));
  }
  if (!input.breaks.empty()) {
    note(
        fmt::format("{} edges of odometry say nothing, as {}: there the trajectory has a break, "
                    "and they are loop closures",
                    input.breaks.size(), input.breaks.front()));
  }
  return notes;
}

GraphSummary summarize(const Input& input, const Solution& solution, const std::vector<Loop>& loops,
                       const std::vector<PosePair>& truth) {
  GraphSummary summary;
  if (!solution.message.empty()) summary.status = solution.signal != 0 ? "interrupted" : "partial";
  summary.message = solution.message;
  summary.method = solution.method;
  summary.poses = input.poses().size();
  summary.landmarks = input.initial.size() - summary.poses;
  summary.solver_s = solution.seconds;
  summary.iterations = solution.iterations;
  summary.objective = solution.objective;
  summary.cost = solution.cost;
  summary.cost_online = solution.cost_online;
  std::vector<ClosureDecision> decisions;
  for (const Loop& loop : loops) {
    if (loop.in_map()) continue;
    decisions.push_back(loop.decision);
    ++(loop.decision.in_force() ? summary.inliers : summary.outliers);
    if (!loop.decision.checkable && loop.decision.accepted()) ++summary.unchecked;
  }
  summary.health = closure_health(decisions);
  summary.health.insert(summary.health.end(), solution.health.begin(), solution.health.end());
  for (HealthEntry& entry : information_health(input.graph)) {
    summary.health.push_back(std::move(entry));
  }
  summary.noise = graph_noise(input, solution, loops);
  for (const Health& part : {fixed_health(input, loops), noise_health(summary.noise),
                             graph_agreement(input, solution, loops, summary.noise)}) {
    summary.health.insert(summary.health.end(), part.begin(), part.end());
  }
  summary.hypotheses = solution.hypotheses.size();
  for (std::size_t k = 0; k < solution.hypotheses.size(); ++k) {
    if (solution.hypotheses[k] == input.first_hypotheses[k]) ++summary.first_hypotheses;
  }
  summary.note = notes_on(input);
  summary.variance_factor = solution.variance_factor;
  summary.members = solution.members;
  summary.start = solution.start;
  for (const StartTrial& trial : solution.starts) {
    summary.starts.push_back({trial.name, trial.cost, trial.iterations});
  }
  if (!solution.steps.empty()) summary.steps = step_statistics(solution.steps);
  if (!truth.empty()) {
    summary.truth.emplace();
    summary.truth->trajectory = trajectory_report(truth);
  }
  return summary;
}

/// Poses and positions measured in the frame of the map.
struct InMap {
  std::size_t all = 0, rejected = 0;

  explicit InMap(const std::vector<Loop>& loops) {
    for (const Loop& loop : loops) {
      all += loop.in_map() ? 1 : 0;
      rejected += loop.in_map() && !loop.decision.in_force() ? 1 : 0;
    }
  }
};

/// summary.json.
nlohmann::ordered_json json_of(const GraphSummary& summary, const InMap& in_map) {
  nlohmann::ordered_json json = summary_json(summary);
  if (in_map.all == 0) return json;
  json["in_map"] = in_map.all - in_map.rejected;
  json["in_map_rejected"] = in_map.rejected;
  return json;
}

void report(const GraphSummary& summary, const InMap& in_map, const OutputDirectory& out) {
  if (!summary.message.empty()) complain("hybrid-pgo: {}\n", summary.message);
  if (!summary.note.empty()) complain("hybrid-pgo: {}\n", summary.note);
  for (const std::string& line : health_lines(summary.health)) complain("hybrid-pgo: {}\n", line);
  say("{} poses, {} landmarks, {} loop closures ({} rejected), ", summary.poses, summary.landmarks,
      summary.inliers + summary.outliers, summary.outliers);
  if (in_map.all > 0) say("{} measured in the map ({} rejected), ", in_map.all, in_map.rejected);
  say("cost {:.6g}, {:.3f} s solving", summary.cost, summary.solver_s);
  if (summary.steps) {
    say(" (step mean {:.3f} ms, p95 {:.3f} ms, max {:.3f} ms)", summary.steps->mean_ms,
        summary.steps->p95_ms, summary.steps->max_ms);
  }
  if (summary.truth && summary.truth->trajectory) {
    say(", rmse {:.4f} m, aligned {:.4f} m", summary.truth->trajectory->unaligned.rmse_m,
        summary.truth->trajectory->aligned.rmse_m);
  }
  say(" -> {}\n", out.folder().string());
  if (summary.certificate) {
    const Certificate& proof = *summary.certificate;
    const std::string verdict =
        proof.verified ? fmt::format("verified, no other poses cost less than {:.6g} times this",
                                     1.0 - proof.stated_gap)
        : proof.isotropic_verified ? "verified for isotropic noise only"
                                   : "not verified";
    say("certificate: {} (relative gap {:.2g}, smallest eigenvalue {:.3g}{}){}\n", verdict,
        proof.relative_gap, proof.min_eigenvalue,
        proof.discrete_gap
            ? fmt::format("; with other decisions, an objective at most {:.3g} lower",
                          *proof.discrete_gap)
            : "",
        proof.message.empty() ? "" : ": " + proof.message);
  }
  if (summary.starts.empty()) return;
  say("the start '{}' won:", summary.start);
  for (const StartSummary& start : summary.starts) {
    say("{} {} cost {:.6g} after {} iterations", &start == &summary.starts.front() ? "" : ",",
        start.start, start.cost, start.iterations);
  }
  say("\n");
}

Provenance provenance(const Options& options) {
  Provenance provenance = options.provenance;
  const bool trusted_file = options.trusted != "all" && options.trusted != "odometry";
  for (const std::string& path :
       {options.graph, options.truth, options.labels, trusted_file ? options.trusted : ""}) {
    provenance.add_input(path);
  }
  warn_of_inputs(provenance);
  return provenance;
}

/// Throws Error if the cost is not finite, naming the measurement at fault.
void check_finite(const Input& input, const Solution& solution, const std::string& file) {
  if (std::isfinite(solution.objective) && std::isfinite(solution.cost)) return;
  std::string which;
  for (const ContinuousFactorPtr& factor : input.factors) {
    if (std::isfinite(factor->cost(solution.values))) continue;
    for (const Key key : factor->keys()) {
      which += fmt::format("{}{}", which.empty() ? "" : " to ", vertex_name(key.index()));
    }
    break;
  }
  throw Error(
      fmt::format("{}: the error of the edge from {} is beyond all numbers; correct it, or "
                  "take it out",
                  file, which.empty() ? "some vertex" : which));
}

/// The path with the true poses of its pairs.
Trajectory true_path(Trajectory path, const std::vector<PosePair>& pairs) {
  for (std::size_t i = 0; i < path.size(); ++i) path[i].pose = pairs.at(i).truth;
  return path;
}

void write_outputs(const Options& options, const OutputDirectory& out, const Input& input,
                   const Solution& solution, const std::vector<Loop>& loops,
                   const std::vector<PosePair>& truth) {
  const std::string title = std::filesystem::path(options.graph).stem().string();
  write_graph(out, input, solution.values);
  out.write("loops.csv", loops_csv(loops));
  if (!solution.hypotheses.empty()) {
    out.write("hypotheses.csv", hypotheses_csv(input, solution.hypotheses));
  }
  if (!solution.steps.empty()) out.write("steps.csv", steps_csv(solution.steps));
  const std::vector<Key> poses = input.poses();
  const Trajectory path = trajectory_of(poses, solution.values);
  const std::vector<std::string> ids = ids_of(poses, solution.values);
  out.write("trajectory.tum", tum_text(path, ids));
  if (!truth.empty()) {
    out.write("trajectory_truth.tum", tum_text(true_path(path, truth), ids));
  }
  if (options.pictures)
    draw_graph(out, options.picture_format, title, input, solution, loops, truth);
}

/// The solution; what goes wrong names vertices as their file does.
Solution solve(const Input& input, const Options& options, std::vector<Loop>& loops) {
  try {
    Solution solution = solve_graph(input, options, loops);
    solution.message = with_vertex_names(solution.message);
    return solution;
  } catch (const Interrupted&) {
    throw;
  } catch (const Error& e) {
    throw Error(with_vertex_names(e.what()));
  }
}

/// Reads the graph, solves it, writes the results and prints a summary. Returns the exit code.
/// Throws on failure.
int optimize(const Options& options) {
  const auto start = Clock::now();
  warn_of(options.warnings);
  if (options.online) note_interrupts();
  Input input =
      read_input(options.graph, options.start, options.shuffle, options.repair_information,
                 !trusts_all(options) && !(options.online && options.trusted.empty()));
  if (input.graph.alternatives_count() > 0 && !options.online) {
    throw Error(options.graph + ": edges with hypotheses need --online");
  }
  if (input.graph.alternatives_count() > 0 && options.certify) {
    throw Error(options.graph + ": has edges with hypotheses, of which nothing can be certified");
  }
  if (options.certify && input.graph.prior_count() > 0) {
    throw Error(options.graph +
                ": has poses measured in the map; only graphs of relative poses can be certified");
  }
  if (options.certify && input.graph.points2.size() + input.graph.points3.size() > 0) {
    throw Error(options.graph + ": has landmarks; only graphs of relative poses can be certified");
  }
  std::map<Key, mrpt::poses::CPose3D> true_poses;
  if (!options.truth.empty()) true_poses = read_true_poses(options.truth, "", input.poses());
  OutputDirectory out(options.output);

  std::vector<Loop> loops;
  Solution solution =
      about({options.graph, options.trusted}, [&] { return solve(input, options, loops); });
  check_finite(input, solution, options.graph);
  if (solution.signal != 0) keep_solved(input, solution);
  if (loops.empty()) loops = find_loops(input, solution.values, solution.decisions);
  std::optional<Certificate> certificate;
  if (options.certify) certificate = certify_solution(input, options, loops, solution);
  const std::vector<PosePair> truth = pair_with_truth(true_poses, solution.values);
  GraphSummary summary = summarize(input, solution, loops, truth);
  summary.certificate = certificate;
  if (!options.labels.empty()) {
    if (!summary.truth) summary.truth.emplace();
    compare_with_labels(options.labels, loops, *summary.truth);
  }
  summary.provenance = provenance(options);
  const InMap in_map(loops);
  write_outputs(options, out, input, solution, loops, truth);
  if (options.report) {
    const std::string title = std::filesystem::path(options.graph).stem().string();
    out.write("report.html",
              report_page(graph_report_json(graph_report(title, input, solution, loops, truth),
                                            json_of(summary, in_map))));
  }
  summary.total_s = std::chrono::duration<double>(Clock::now() - start).count();
  const std::vector<std::string> told = out.publish(json_of(summary, in_map));
  const int code = settle(solution.signal != 0       ? kExitInterrupted + solution.signal
                          : solution.message.empty() ? kExitOk
                                                     : kExitPartial);
  for (const std::string& text : told) complain("hybrid-pgo: {}\n", text);
  report(summary, in_map, out);
  return code;
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-pgo", [&] {
    int exit_code = hybrid::kExitOk;
    const auto options = hybrid::parse_options(argc, argv, exit_code);
    return options ? hybrid::optimize(*options) : exit_code;
  });
}
