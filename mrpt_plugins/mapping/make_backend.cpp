// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/core/key_letters.h"
#include "mrpt_plugins/bridge/read_options.h"
#include "mrpt_plugins/mapping/backend.h"
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

}  // namespace hybrid
