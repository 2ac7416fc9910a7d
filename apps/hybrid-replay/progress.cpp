// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-replay/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace hybrid {

Progress::Progress()
    : terminal_(isatty(fileno(stderr)) == 1), start_(Clock::now()), shown_(start_) {}

void Progress::update(double fraction, std::size_t keyframes, std::size_t landmarks,
                      double objective) {
  const Clock::time_point now = Clock::now();
  if (!terminal_ || now - shown_ < std::chrono::milliseconds(100)) return;
  shown_ = now;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double left = fraction > 0 ? elapsed * (1 - fraction) / fraction : 0;
  fmt::print(stderr,
             "\r\033[K{:3.0f} %  {} keyframes  {} landmarks  objective {:.6g}  {:.0f}/s  {:.0f} s "
             "left",
             100 * fraction, keyframes, landmarks, objective,
             static_cast<double>(keyframes) / elapsed, left);
  std::fflush(stderr);
  line_shown_ = true;
}

void Progress::message(const std::string& text) {
  clear();
  fmt::print(stderr, "{}\n", text);
}

void Progress::clear() {
  if (line_shown_) fmt::print(stderr, "\r\033[K");
  line_shown_ = false;
}

}  // namespace hybrid
