// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <string>

#include "apps/program.h"

namespace hybrid {

/// A progress line on standard error: rewritten on a terminal; in a pipe, each text is a line of
/// its own.
class ProgressLine {
 public:
  ProgressLine() : terminal_(isatty(fileno(stderr)) == 1) {}
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine() { clear(); }

  bool terminal() const { return terminal_; }
  /// Whether to show the next text on a terminal: at most ten times per second.
  bool is_due() {
    const Clock::time_point now = Clock::now();
    if (!terminal_ || now - last_ < std::chrono::milliseconds(100)) return false;
    last_ = now;
    return true;
  }
  /// Time since construction [s].
  double elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  /// Estimated time left, as "12 s left", by the share of the work that is done; "" before a
  /// hundredth is done, from which nothing can be told.
  std::string time_left(double share) const {
    return share >= 0.01 ? fmt::format("{:.0f} s left", elapsed() * (1 - share) / share) : "";
  }
  void show(const std::string& text) {
    complain("{}", terminal_ ? "\r\033[K" + text : text + "\n");
    std::fflush(stderr);
    shown_ = terminal_;
  }
  /// Prints a separate line.
  void message(const std::string& text) {
    clear();
    complain("{}\n", text);
  }
  void clear() {
    if (shown_) std::fputs("\r\033[K", stderr);
    shown_ = false;
  }

 private:
  using Clock = std::chrono::steady_clock;

  Clock::time_point start_ = Clock::now(), last_ = start_;
  bool terminal_;
  bool shown_ = false;
};

}  // namespace hybrid
