// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-pgo/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <string>

namespace hybrid {

Progress::Progress(std::size_t poses)
    : poses_(poses), terminal_(isatty(fileno(stderr)) == 1), start_(Clock::now()), shown_(start_) {}

Progress::~Progress() {
  if (line_shown_) std::fputs("\r\033[K", stderr);
}

void Progress::update(std::size_t done, double cost) {
  const Clock::time_point now = Clock::now();
  if (terminal_ ? now - shown_ < std::chrono::milliseconds(100) : 10 * done / poses_ == tenths_) {
    return;
  }
  shown_ = now;
  tenths_ = 10 * done / poses_;
  const double rate =
      static_cast<double>(done) / std::chrono::duration<double>(now - start_).count();
  const std::string text = fmt::format("{:3d} %  {} of {} poses  cost {:.6g}  {:.0f}/s",
                                       100 * done / poses_, done, poses_, cost, rate);
  fmt::print(stderr, terminal_ ? "\r\033[K{}" : "{}\n", text);
  std::fflush(stderr);
  line_shown_ = terminal_;
}

}  // namespace hybrid
