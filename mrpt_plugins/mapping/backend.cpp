// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/backend.h"

#include <algorithm>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "mrpt_plugins/bridge/read_options.h"
#include "mrpt_plugins/mapping/batch_backend.h"
#include "mrpt_plugins/mapping/detail/window_backend.h"

namespace hybrid {

namespace {

WindowOptions read_window_options(IniSection& solver, const std::string& mode) {
  WindowOptions options;
  using Mode = WindowOptions::Mode;
  if (mode == "fixed_lag") options.mode = Mode::kFixedLag;
  if (mode == "filter") options.mode = Mode::kFilter;
  if (mode == "bounded") {
    options.mode = Mode::kBounded;
    options.states = {key_letter::kPose};
  }
  read_options(solver, options);
  return options;
}

}  // namespace

void add_probabilities(AssignmentPosterior&& posterior, Uncertainty& out) {
  for (auto& [key, variable] : posterior.variables) {
    for (double error : variable.standard_error) {
      out.standard_error = std::max(out.standard_error, error);
    }
    out.probabilities[key] = std::move(variable.p);
  }
}

std::unique_ptr<Backend> make_backend(IniSection solver) {
  const std::string mode = solver.choice(
      "mode", "bounded", {"bounded", "incremental", "batch", "fixed_lag", "filter"},
      "batch: the whole graph at the end; the others are online, with an estimate after each "
      "keyframe. bounded: of the past what the place takes; incremental: all of it; fixed_lag: a "
      "window of it; filter: the newest pose and all landmarks. All solve what they keep to "
      "convergence at the end");
  AlternatingOptions batch;
  read_options(solver, batch, "batch: ");
  read_option(solver, batch.continuous, "threads", "batch: ");
  const int solve_every =
      solver.get("solve_every", 0, "batch: keyframes between solves on the way; 0: none", {0, 1e9});
  SmootherOptions smoother;
  read_options(solver, smoother, "online: ");
  const WindowOptions window = read_window_options(solver, mode);
  if (mode == "batch") return std::make_unique<BatchBackend>(batch, solve_every);
  return std::make_unique<WindowBackend>(window, smoother);
}

void add_work(BackendReport& into, const BackendReport& from) {
  into.add(from);
  if (from.cost != 0 || into.cost == 0) into.cost = from.cost;
  for (Flip flip : from.flipped) {
    flip.half_step += into.objectives.size();
    into.flipped.push_back(flip);
  }
  into.objectives.insert(into.objectives.end(), from.objectives.begin(), from.objectives.end());
  into.warnings.insert(into.warnings.end(), from.warnings.begin(), from.warnings.end());
}

}  // namespace hybrid
