// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <string>

#include "apps/program.h"

namespace hybrid {

/// A line on standard error that tells how far a program is: on a terminal it renews itself, in a
/// pipe every text is a line of its own.
class ProgressLine {
 public:
  ProgressLine() : terminal_(isatty(fileno(stderr)) == 1) {}
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine() { clear(); }

  bool terminal() const { return terminal_; }
  /// Whether a terminal is to see the next text: ten times per second at most.
  bool is_due() {
    const Clock::time_point now = Clock::now();
    if (!terminal_ || now - last_ < std::chrono::milliseconds(100)) return false;
    last_ = now;
    return true;
  }
  /// Since the line was made [s].
  double elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  /// "12 s left", by the share of the work that is done; "" before there is any.
  std::string time_left(double share) const {
    return share > 0 ? fmt::format("{:.0f} s left", elapsed() * (1 - share) / share) : "";
  }
  void show(const std::string& text) {
    complain("{}", terminal_ ? "\r\033[K" + text : text + "\n");
    std::fflush(stderr);
    shown_ = terminal_;
  }
  /// Prints a line that stays.
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
