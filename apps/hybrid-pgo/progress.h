// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <chrono>
#include <cstddef>

#include "apps/progress_line.h"

namespace hybrid {

/// Tells the user on standard error how far the solver is: one line that renews itself on a
/// terminal; in a pipe a plain line per tenth of the graph.
class Progress {
 public:
  explicit Progress(std::size_t poses) : poses_(poses) {}

  /// `done` poses are in; on a terminal at most ten times per second.
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
