// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <chrono>
#include <cstddef>
#include <string>

#include "apps/progress_line.h"

namespace hybrid {

/// Progress on standard error: how many trials have ended. One line that is rewritten on a
/// terminal; in a pipe, a line per twentieth.
class Progress {
 public:
  /// `todo` is the number of trials to run.
  explicit Progress(std::size_t todo) : todo_(todo) {}

  /// Counts a trial that ended; `what` names it.
  void ended(const std::string& what);
  /// Prints a separate line.
  void message(const std::string& text) { line_.message(text); }

 private:
  void show(const std::string& what);

  std::size_t todo_;
  std::size_t done_ = 0;
  std::size_t twentieths_ = 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  ProgressLine line_;
};

}  // namespace hybrid
