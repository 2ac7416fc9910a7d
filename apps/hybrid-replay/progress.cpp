// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-replay/progress.h"

#include "libhybrid/core/elapsed.h"

namespace hybrid {

void Progress::update(double fraction, std::size_t keyframes, std::size_t landmarks,
                      double objective) {
  const Clock::time_point now = Clock::now();
  if (!line_.terminal() || now - shown_ < std::chrono::milliseconds(100)) return;
  shown_ = now;
  const double elapsed = seconds_since(start_);
  const double left = fraction > 0 ? elapsed * (1 - fraction) / fraction : 0;
  line_.show(fmt::format(
      "{:3.0f} %  {} keyframes  {} landmarks  objective {:.6g}  {:.0f}/s  {:.0f} s left",
      100 * fraction, keyframes, landmarks, objective, static_cast<double>(keyframes) / elapsed,
      left));
}

}  // namespace hybrid
