// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <chrono>
#include <cstddef>

#include "apps/progress_line.h"

namespace hybrid {

/// Progress of the solver on standard error. One line that is rewritten on a terminal; in a pipe, a
/// line per tenth of the graph.
class Progress {
 public:
  explicit Progress(std::size_t poses) : poses_(poses) {}

  /// `done` poses are in the graph. Prints at most ten times per second on a terminal.
  void update(std::size_t done, double cost);

 private:
  using Clock = std::chrono::steady_clock;

  std::size_t poses_;
  std::size_t tenths_ = 0;
  Clock::time_point start_ = Clock::now();
  Clock::time_point shown_ = start_;
  ProgressLine line_;
};

}  // namespace hybrid
