// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace hybrid {

/// Tells the user how far a replay is, on standard error: one line that renews itself on a
/// terminal; in a pipe nothing but the messages.
class Progress {
 public:
  Progress();

  /// Renews the line, at most ten times per second. `fraction` of the log is done.
  void update(double fraction, std::size_t keyframes, std::size_t landmarks, double objective);

  /// Prints a line of its own.
  void message(const std::string& text);

 private:
  using Clock = std::chrono::steady_clock;

  void clear();

  bool terminal_;
  bool line_shown_ = false;
  Clock::time_point start_;
  Clock::time_point shown_;
};

}  // namespace hybrid
