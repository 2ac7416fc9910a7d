// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-experiment/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

#include "libhybrid/core/elapsed.h"

namespace hybrid {

Progress::Progress(std::size_t todo)
    : todo_(todo), terminal_(isatty(fileno(stderr)) == 1), start_(Clock::now()) {}

Progress::~Progress() {
  if (line_shown_) std::fputs("\r\033[K", stderr);
}

void Progress::ended(const std::string& what) {
  ++done_;
  const std::size_t twentieths = 20 * done_ / todo_;
  if (terminal_ || twentieths != twentieths_) show(what);
  twentieths_ = twentieths;
}

void Progress::message(const std::string& text) {
  if (line_shown_) std::fputs("\r\033[K", stderr);
  line_shown_ = false;
  fmt::print(stderr, "{}\n", text);
}

void Progress::show(const std::string& what) {
  const double seconds = seconds_since(start_);
  const double left = seconds / static_cast<double>(done_) * static_cast<double>(todo_ - done_);
  const std::string text = fmt::format("{:3d} %  {} of {} trials  about {:.0f} s left  {}",
                                       100 * done_ / todo_, done_, todo_, left, what);
  fmt::print(stderr, terminal_ ? "\r\033[K{}" : "{}\n", text);
  std::fflush(stderr);
  line_shown_ = terminal_;
}

}  // namespace hybrid
