// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/core/key_letters.h"
#include "mrpt_plugins/mapping/backend.h"
#include "mrpt_plugins/mapping/batch_backend.h"
#include "mrpt_plugins/mapping/detail/window_backend.h"

namespace hybrid {

namespace {

AlternatingOptions read_batch_options(IniSection& solver) {
  AlternatingOptions options;
  options.max_iterations = solver.get(
      "max_iterations", options.max_iterations,
      "batch: at most so many pairs of a discrete and a continuous half-step", IniRange{1, 1e6});
  options.relative_decrease =
      solver.get("relative_decrease", options.relative_decrease,
                 "batch: converged once a pair of half-steps lowers the objective by less than "
                 "this share of the cost",
                 IniRange{1e-15, 1});
  options.continuous_iterations =
      solver.get("linear_solves", options.continuous_iterations,
                 "batch: at most, in one continuous half-step", IniRange{1, 1e6});
  options.continuous.threads =
      solver.get("threads", options.continuous.threads,
                 "batch: 0 for one per core, at most 4; the result is the same", IniRange{0, 256});
  return options;
}

SmootherOptions read_smoother_options(IniSection& solver) {
  SmootherOptions options;
  options.relinearize =
      solver.get("relinearize", options.relinearize,
                 "online: a factor is linearised again once its linear model is off by more than "
                 "this, in units of the objective",
                 IniRange{1e-12, 1e6});
  options.wildfire =
      solver.get("wildfire", options.wildfire,
                 "online: a step is propagated while it lowers the objective by more than this",
                 IniRange{1e-15, 1e6});
  options.bend =
      solver.get("bend", options.bend,
                 "online: a part of the map is left as it is, or moved as a whole, while "
                 "that raises the objective by no more than this",
                 IniRange{0.0, 1e6});
  options.bend_share = solver.get(
      "bend_share", options.bend_share,
      "online: besides, for each of its factors, by this share of what a factor costs in the "
      "mean",
      IniRange{0.0, 1.0});
  options.rounds = solver.get("rounds", options.rounds,
                              "online: alternation rounds for each keyframe", IniRange{1, 1000});
  return options;
}

WindowOptions read_window_options(IniSection& solver, const std::string& mode) {
  WindowOptions options;
  using Mode = WindowOptions::Mode;
  if (mode == "fixed_lag") options.mode = Mode::kFixedLag;
  if (mode == "filter") options.mode = Mode::kFilter;
  if (mode == "bounded") {
    options.mode = Mode::kBounded;
    options.states = {key_letter::kPose};
  }
  options.complete =
      solver.get("complete", options.complete,
                 "bounded: keyframes up to which nothing is marginalised", IniRange{0, 1e9});
  options.sightings =
      solver.get("sightings", options.sightings,
                 "bounded: later, a keyframe stays until this many newer ones have seen each of "
                 "the landmarks that it saw",
                 IniRange{1, 1e9});
  options.lag = solver.get("lag", options.lag,
                           "fixed_lag: keyframes that a variable stays after its last measurement; "
                           "0: for ever",
                           IniRange{0, 1e9});
  return options;
}

}  // namespace

std::unique_ptr<Backend> make_backend(IniSection solver) {
  const std::string mode = solver.choice(
      "mode", "bounded", {"bounded", "incremental", "batch", "fixed_lag", "filter"},
      "batch: the whole graph at the end; the others are online, with an estimate after each "
      "keyframe. bounded: of the past what the place takes; incremental: all of it; fixed_lag: a "
      "window of it; filter: the newest pose and all landmarks. All solve what they keep to "
      "convergence at the end");
  const AlternatingOptions batch = read_batch_options(solver);
  const int solve_every = solver.get(
      "solve_every", 0, "batch: keyframes between solves on the way; 0: none", IniRange{0, 1e9});
  const SmootherOptions smoother = read_smoother_options(solver);
  const WindowOptions window = read_window_options(solver, mode);
  if (mode == "batch") return std::make_unique<BatchBackend>(batch, solve_every);
  return std::make_unique<WindowBackend>(window, smoother);
}

}  // namespace hybrid
