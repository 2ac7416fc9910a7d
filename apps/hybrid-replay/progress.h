// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "apps/progress_line.h"

namespace hybrid {

/// Tells the user how far a replay is, on standard error: one line that renews itself on a
/// terminal; in a pipe nothing but the messages.
class Progress {
 public:
  /// Renews the line, at most ten times per second. `fraction` of the log is done, where known.
  void update(std::optional<double> fraction, std::size_t keyframes, std::size_t landmarks,
              double objective);

  /// Prints a line of its own.
  void message(const std::string& text) { line_.message(text); }
  /// Removes the line.
  void clear() { line_.clear(); }

 private:
  ProgressLine line_;
};

}  // namespace hybrid
