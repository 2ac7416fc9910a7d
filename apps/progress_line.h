// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <unistd.h>

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
  bool terminal_;
  bool shown_ = false;
};

}  // namespace hybrid
