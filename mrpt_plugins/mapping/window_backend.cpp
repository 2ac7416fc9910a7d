// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/detail/window_backend.h"

#include <algorithm>
#include <chrono>
#include <unordered_set>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/discrete/inference.h"
#include "libhybrid/solvers/starts.h"

namespace hybrid {
namespace {

/// Replaces or adds a value.
void put(Values& values, Key key, const Values& from) {
  const double* x = from.data(key);
  const VariableType type = from.type(key);
  if (values.contains(key)) {
    std::copy_n(x, type.size, values.data(values.slot(key)));
  } else {
    values.insert(key, type, x);
  }
}

}  // namespace

std::string WindowBackend::mode() const {
  switch (window_.mode) {
    case WindowOptions::Mode::kFull:
      return "incremental";
    case WindowOptions::Mode::kFixedLag:
      return "fixed_lag";
    case WindowOptions::Mode::kFilter:
      return "filter";
    case WindowOptions::Mode::kBounded:
      return "bounded";
  }
  return {};
}

const Values& WindowBackend::values() const {
  return is_whole() ? smoother_.smoother().values() : merged_.values;
}

const Assignment& WindowBackend::assignment() const {
  return is_whole() ? smoother_.smoother().assignment() : merged_.assignment;
}

/// Copies from the window to the estimate of all variables what has changed there, of the variables
/// that have just left it, and of those that left before and hang on what has changed.
void WindowBackend::merge(const std::vector<Key>& changed, const std::vector<Key>& left,
                          const std::vector<Key>& left_discrete) {
  const Values& live = smoother_.smoother().values();
  const Assignment& chosen = smoother_.smoother().assignment();
  if (is_whole()) {
    if (is_full() || left.empty()) return;
    merged_ = {live, chosen};
  }
  const Estimate& past = smoother_.past();
  for (const Key key : left) put(merged_.values, key, past.values);
  for (const Key key : left_discrete) merged_.assignment.set(key, past.assignment.at(key));
  for (const Key key : changed) {
    if (live.contains(key)) put(merged_.values, key, live);
    if (chosen.contains(key)) merged_.assignment.set(key, chosen.at(key));
  }
  if (!is_bounded()) return;
  const Values moved = smoother_.moved_past_states(changed);
  for (const Key key : moved.keys()) put(merged_.values, key, moved);
}

BackendReport WindowBackend::update(const Delta& delta) {
  return take(smoother_.update(delta), delta);
}

BackendReport WindowBackend::propose(const Proposal& proposal) {
  const WindowReport trial = smoother_.propose(proposal);
  return trial.status == UpdateReport::Status::kTurnedDown ? report_of(trial)
                                                           : take(trial, proposal.delta);
}

/// Takes an update of the window over into the estimate of all variables.
BackendReport WindowBackend::take(const WindowReport& update, const Delta& delta) {
  if (update.status == UpdateReport::Status::kSingular) throw Error(update.message);
  for (const Key key : delta.remove_values) {
    if (merged_.values.contains(key)) merged_.values.erase(key);
  }
  eliminated_ += update.eliminated;
  merge(update.changed, update.left, update.left_discrete);
  return report_of(update);
}

BackendReport WindowBackend::finish() {
  const UpdateReport update = smoother_.converge();
  BackendReport report = report_of(update);
  starts_.clear();
  if (is_whole() && affords_chordal_start())
    add_work(report, report_of(solve_from_chordal_start()));
  merge(update.changed, {}, {});
  const Values past = smoother_.past_states();
  for (const Key key : past.keys()) put(merged_.values, key, past);
  return report;
}

BackendReport WindowBackend::settle() {
  const UpdateReport update = smoother_.settle();
  merge(update.changed, {}, {});
  return report_of(update);
}

/// Whether another start takes at most a tenth of the work so far, or next to none. It solves
/// linear systems of all variables: one for each row of the rotations, for the translations, and up
/// to ten of the alternation, most of them twice.
bool WindowBackend::affords_chordal_start() const {
  constexpr std::int64_t kSystems = 20, kShare = 10, kLittle = 20000;  // variables: some 0.1 s
  const auto variables = static_cast<std::int64_t>(smoother_.smoother().values().size());
  const std::int64_t work = kSystems * variables;
  return work <= kLittle || kShare * work <= eliminated_;
}

/// Tries another start than that of the way here, and goes on from it if it leads lower.
UpdateReport WindowBackend::solve_from_chordal_start() {
  const IncrementalSmoother& smoother = smoother_.smoother();
  const auto start = std::chrono::steady_clock::now();
  const ChordalTrial trial = try_chordal_start(smoother.graph(), smoother.estimate());
  UpdateReport report;
  report.objective_after = smoother.objective();
  report.seconds = seconds_since(start);
  if (!trial.tried) return report;
  starts_ = {{"objective_from_online", smoother.objective()},
             {"objective_from_chordal", trial.objective}};
  if (trial.better) report.go_on(smoother_.converge_from(trial.better->values));
  return report;
}

BackendReport WindowBackend::report_of(const UpdateReport& update) const {
  BackendReport report{update, {}, {}};
  report.objective_after = smoother_.smoother().objective();
  report.cost = report.objective_after - smoother_.smoother().constant();
  if (update.status == UpdateReport::Status::kSingular) report.warnings.push_back(update.message);
  return report;
}

std::map<std::string, double> WindowBackend::statistics() const {
  std::map<std::string, double> all = starts_;
  if (is_bounded()) {
    all["keyframes_marginalized"] = static_cast<double>(smoother_.past().values.size());
    all["divergence_nat"] = smoother_.divergence();
    all["chain_breaks"] = smoother_.breaks();
  }
  return all;
}

/// What was known of variables when they left the graph.
void WindowBackend::add_past(const std::vector<Key>& continuous,
                             const std::vector<DiscreteKey>& discrete, Uncertainty& out) const {
  for (const Key key : continuous) {
    if (const auto* covariance = smoother_.past_covariance(key)) {
      out.covariances.emplace(key, *covariance);
    }
  }
  for (const DiscreteKey& key : discrete) {
    const Table* table = smoother_.past_table(key.key);
    if (table == nullptr) continue;
    const DiscreteMarginals marginals = discrete_marginals({table});
    const auto p = marginals.at(key.key);
    out.probabilities[key.key].assign(p.data(), p.data() + p.size());
  }
}

Uncertainty WindowBackend::uncertainty(const std::vector<Key>& continuous,
                                       const std::vector<DiscreteKey>& discrete) const {
  Uncertainty out;
  const IncrementalSmoother& smoother = smoother_.smoother();
  const std::unordered_set<Key> wanted(continuous.begin(), continuous.end());
  if (!wanted.empty()) {
    smoother.visit_covariances([&](Key key, const Eigen::MatrixXd& covariance) {
      if (wanted.count(key) != 0) out.covariances[key] = covariance;
    });
  }
  add_past(continuous, discrete, out);
  std::vector<Key> inside;
  for (const DiscreteKey& key : discrete) {
    if (smoother.assignment().contains(key.key)) inside.push_back(key.key);
  }
  if (inside.empty()) return out;
  const JointCovariance covariance = [&](const std::vector<Key>& keys) {
    return smoother.joint_covariance(keys);
  };
  add_probabilities(posterior_marginals(smoother.graph(), smoother.estimate(), inside, covariance),
                    out);
  return out;
}

}  // namespace hybrid
