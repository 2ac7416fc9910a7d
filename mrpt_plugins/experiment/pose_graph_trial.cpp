// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/pose_graph_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include "libhybrid/core/error.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/io/read_pairs.h"
#include "libhybrid/io/text_reader.h"
#include "libhybrid/methods/solve_online.h"
#include "libhybrid/pose_graph/false_closures.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/selection/closure_posterior.h"
#include "libhybrid/solvers/starts.h"
#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;
using KeyPair = std::pair<Key, Key>;

std::vector<Key> poses_of(const Values& values) {
  std::vector<Key> poses;
  for (Key key : values.keys()) {
    if (key.letter() == key_letter::kPose) poses.push_back(key);
  }
  std::sort(poses.begin(), poses.end());
  return poses;
}

ClosureLabel to_label(bool is_true) {
  return is_true ? ClosureLabel::kTrue : ClosureLabel::kFalse;
}

/// Whether each of `count` closures is labelled as true. Closures behind the labelled ones are
/// added false closures.
std::vector<bool> known_true(const std::vector<ClosureLabel>& labels, std::size_t count) {
  std::vector<bool> result;
  for (ClosureLabel label : labels) result.push_back(label == ClosureLabel::kTrue);
  result.resize(count, false);
  return result;
}

std::set<KeyPair> read_labels(const std::string& path) {
  std::set<KeyPair> pairs;
  for (const VertexPair& pair : read_pairs(path, false)) {
    pairs.insert(std::minmax(Key(key_letter::kPose, pair.i), Key(key_letter::kPose, pair.j)));
  }
  return pairs;
}

/// Whether a measured relative pose agrees with the true poses, if both are known.
template <class Edge>
ClosureLabel agrees(const Edge& edge, const PreparedGraph& prepared, const GraphPlan& plan) {
  const auto from = prepared.truth.find(edge.from);
  const auto to = prepared.truth.find(edge.to);
  if (from == prepared.truth.end() || to == prepared.truth.end()) return ClosureLabel::kUnknown;
  const CPose3D error = (to->second - from->second) - to_mrpt(edge.measured);
  const double trace = error.getRotationMatrix().trace();
  const double angle = std::acos(std::clamp(0.5 * (trace - 1.0), -1.0, 1.0));
  return to_label(error.norm() <= plan.label_distance && angle <= plan.label_angle);
}

void label(const GraphPlan& plan, const std::string& variant, PreparedGraph& prepared) {
  std::set<KeyPair> pairs;
  if (!plan.labels.empty()) pairs = read_labels(with_variant(plan.labels, variant));
  const OdometryEdges is_odometry(prepared.graph);
  const auto add = [&](const auto& edges) {
    for (const auto& edge : edges) {
      if (is_odometry(edge.from, edge.to)) continue;
      prepared.labels.push_back(!plan.labels.empty()
                                    ? to_label(pairs.count(std::minmax(edge.from, edge.to)) != 0)
                                : plan.label_distance > 0.0 ? agrees(edge, prepared, plan)
                                                            : ClosureLabel::kTrue);
    }
  };
  add(prepared.graph.poses2);
  add(prepared.graph.poses3);
}

/// The edges that are odometry or true closures.
template <class Edge>
std::vector<Edge> true_edges(const std::vector<Edge>& edges,
                             const std::vector<ClosureLabel>& labels,
                             const OdometryEdges& is_odometry, std::size_t& closure) {
  std::vector<Edge> out;
  for (const Edge& edge : edges) {
    if (is_odometry(edge.from, edge.to) || labels.at(closure++) == ClosureLabel::kTrue) {
      out.push_back(edge);
    }
  }
  return out;
}

/// Poses at the best optimum with the true closures that any start leads to.
void find_reference(PreparedGraph& prepared) {
  PoseGraph graph = prepared.graph;
  const OdometryEdges is_odometry(prepared.graph);
  std::size_t closure = 0;
  graph.poses2 = true_edges(graph.poses2, prepared.labels, is_odometry, closure);
  graph.poses3 = true_edges(graph.poses3, prepared.labels, is_odometry, closure);
  const std::vector<ContinuousFactorPtr> factors = to_factors(graph, prepared.initial);
  HybridGraph hybrid;
  for (const ContinuousFactorPtr& factor : factors) hybrid.add(factor);
  SolverOptions options;
  options.threads = 1;
  options.relative_decrease = 1e-10;
  const StartsResult best = solve_from_starts(
      hybrid, pose_graph_starts(graph, factors, "first", prepared.initial), options);
  if (best.report.status != SolverStatus::kConverged) {
    prepared.no_reference =
        fmt::format("the optimum of the true closures is not known: {} after {} iterations",
                    to_string(best.report.status), best.report.iterations);
    return;
  }
  prepared.reference_cost = best.report.final_cost();
  for (Key key : poses_of(best.values)) {
    prepared.truth.emplace(key, pose_at(best.values, key));
  }
}

/// Whether exactly the closures that are known as true are in force.
bool accepts_the_true(const RobustResult& result, const std::vector<bool>& truth) {
  for (std::size_t k = 0; k < result.decisions.size(); ++k) {
    if (result.decisions[k].accepted() != truth.at(k)) return false;
  }
  return true;
}

/// Why the poses of a result cannot be compared with the truth; empty if they can.
std::string why_not_compared(const PreparedGraph& prepared, const RobustResult& result,
                             const std::vector<bool>& truth) {
  constexpr double kSameMinimum = 1e-3;  // share of a cost
  if (!prepared.no_reference.empty()) return prepared.no_reference;
  if (!prepared.reference_cost || !accepts_the_true(result, truth)) return "";
  if (result.cost > (1.0 - kSameMinimum) * *prepared.reference_cost - kSameMinimum) return "";
  return fmt::format(
      "the reference is not the best optimum: it costs {:.6g}, and the same closures {:.6g} here",
      *prepared.reference_cost, result.cost);
}

void compare_poses(const Values& values, const PreparedGraph& prepared, TrialResult& trial) {
  std::vector<PosePair> pairs;
  for (const auto& [key, pose] : prepared.truth) pairs.push_back({pose_at(values, key), pose});
  const TrajectoryErrors errors = trajectory_report(pairs).aligned;
  trial.metrics["ate_mean_m"] = errors.mean_m;
  trial.metrics["ate_rmse_m"] = errors.rmse_m;
  trial.metrics["rotation_mean_deg"] = errors.rotation_mean_deg;
}

void compare_decisions(const RobustResult& result, std::vector<ClosureLabel> labels,
                       TrialResult& trial) {
  labels.resize(result.decisions.size(), ClosureLabel::kFalse);
  std::vector<bool> truth;
  double right = 0, accepted = 0, all_true = 0, brier = 0, log_loss = 0;
  std::vector<double> probabilities;
  for (std::size_t k = 0; k < labels.size(); ++k) {
    if (labels[k] == ClosureLabel::kUnknown) continue;
    const ClosureDecision& decision = result.decisions[k];
    const bool is_true = labels[k] == ClosureLabel::kTrue;
    accepted += decision.accepted();
    all_true += is_true;
    right += decision.accepted() && is_true;
    const double p = decision.inlier_probability;
    truth.push_back(is_true);
    probabilities.push_back(p);
    brier += 2.0 * (p - is_true) * (p - is_true);
    log_loss -= std::log(std::max(1e-15, is_true ? p : 1.0 - p));
  }
  const auto count = static_cast<double>(truth.size());
  auto& metrics = trial.metrics;
  metrics["closures"] = count;
  metrics["accepted"] = accepted;
  if (accepted > 0) metrics["precision"] = right / accepted;
  if (all_true > 0) metrics["recall"] = right / all_true;
  if (count == 0) return;
  metrics["false_share"] = 1.0 - all_true / count;
  metrics["brier"] = brier / count;
  metrics["log_loss"] = log_loss / count;
  trial.reliability = reliability_text(probabilities, truth);
}

}  // namespace

const std::vector<std::string>& pose_graph_metrics() {
  static const std::vector<std::string> kNames = {
      "seconds",   "cpu_s",  "ate_mean_m",  "ate_rmse_m", "rotation_mean_deg",
      "objective", "cost",   "iterations",  "closures",   "accepted",
      "precision", "recall", "false_share", "brier",      "log_loss"};
  return kNames;
}

PreparedGraph prepare_graph(const GraphPlan& plan, const std::string& variant) {
  const std::string file = with_variant(plan.file, variant);
  PreparedGraph prepared;
  prepared.graph = read_graph(file, {plan.repair_information});
  try {
    prepared.initial = initialize_from_odometry(prepared.graph);
  } catch (const Error& e) {
    throw Error(file + ": " + e.what());
  }
  if (plan.start == "chordal" || plan.start == "tree") {
    prepared.initial = pose_graph_start(prepared.graph, plan.start);
  }
  bool complete = plan.start == "file";
  for (Key key : prepared.initial.keys()) {
    complete = complete && prepared.graph.values.contains(key);
  }
  if (complete) prepared.initial = prepared.graph.values;
  if (!plan.truth.empty()) {
    prepared.truth = read_true_poses(plan.truth, plan.truth_times, poses_of(prepared.initial));
  }
  label(plan, variant, prepared);
  if (plan.truth.empty()) find_reference(prepared);
  return prepared;
}

TrialResult run_pose_graph_trial(const PreparedGraph& prepared, const Trial& trial,
                                 const MethodOptions& options) {
  RobustTask task;
  task.graph = add_false_closures(prepared.graph, trial.outlier_rate, trial.seed);
  task.problem = to_robust_problem(task.graph, prepared.initial);
  task.truth = known_true(prepared.labels, task.problem.closures.size());
  const std::clock_t start = std::clock();
  RobustResult result = robust_method(trial.method).solve(task, options);
  TrialResult out;
  out.metrics["cpu_s"] = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  integrate_poses(task.problem, options.common.mixture, result);
  out.metrics["seconds"] = result.seconds;
  out.metrics["objective"] = result.objective;
  out.metrics["cost"] = result.cost;
  out.metrics["iterations"] = result.iterations;
  if (!result.converged) {
    out.status = "partial";
    out.message = result.message;
  }
  const std::string why = why_not_compared(prepared, result, task.truth);
  if (why.empty()) {
    compare_poses(result.values, prepared, out);
  } else {
    out.message += (out.message.empty() ? "" : "; ") + why;
  }
  compare_decisions(result, prepared.labels, out);
  return out;
}

std::string reliability_text(const std::vector<double>& probabilities,
                             const std::vector<bool>& truth) {
  std::vector<long> count(10, 0), right(10, 0);
  std::vector<double> sum(10, 0.0);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const int tenth = std::clamp(static_cast<int>(10.0 * probabilities[k]), 0, 9);
    ++count[tenth];
    right[tenth] += truth[k];
    sum[tenth] += probabilities[k];
  }
  std::string text;
  for (int i = 0; i < 10; ++i) {
    text += fmt::format("{}{}/{}/{:.6g}", i == 0 ? "" : " ", count[i], right[i], sum[i]);
  }
  return text;
}

void ReliabilitySum::add(const std::string& text, double brier, double log_loss) {
  if (text.empty()) return;
  std::string words = text;
  std::replace(words.begin(), words.end(), '/', ' ');
  TextReader reader(words, "counts of probabilities '" + text + "'", {TextFormat::Cut::kWords, ""});
  const auto row = reader.next();
  row->expect(3 * tenths_.size(), "count/right/sum for each tenth");
  const std::vector<double> numbers = row->numbers(0, row->size());
  double closures = 0;
  for (std::size_t i = 0; i < tenths_.size(); ++i) {
    tenths_[i].count += numbers[3 * i];
    tenths_[i].right += numbers[3 * i + 1];
    tenths_[i].sum += numbers[3 * i + 2];
    closures += numbers[3 * i];
  }
  closures_ += closures;
  brier_ += closures * brier;
  log_loss_ += closures * log_loss;
}

Calibration ReliabilitySum::calibration() const {
  Calibration result;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  result.predictions = static_cast<std::size_t>(closures_);
  result.brier = closures_ > 0 ? brier_ / closures_ : nan;
  result.log_loss = closures_ > 0 ? log_loss_ / closures_ : nan;
  result.expected_error = closures_ > 0 ? 0.0 : nan;
  for (std::size_t i = 0; i < tenths_.size(); ++i) {
    const Tenth& tenth = tenths_[i];
    ReliabilityBin bin;
    bin.lower = 0.1 * static_cast<double>(i);
    bin.upper = bin.lower + 0.1;
    bin.count = static_cast<std::size_t>(tenth.count);
    bin.mean_predicted = tenth.count > 0 ? tenth.sum / tenth.count : nan;
    bin.observed = tenth.count > 0 ? tenth.right / tenth.count : nan;
    if (tenth.count > 0) {
      result.expected_error +=
          tenth.count / closures_ * std::abs(bin.observed - bin.mean_predicted);
    }
    result.bins.push_back(bin);
  }
  return result;
}

}  // namespace hybrid
