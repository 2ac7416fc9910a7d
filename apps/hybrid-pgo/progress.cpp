// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-pgo/progress.h"

#include "libhybrid/core/elapsed.h"

namespace hybrid {

void Progress::update(std::size_t done, double cost) {
  const Clock::time_point now = Clock::now();
  if (line_.terminal() ? now - shown_ < std::chrono::milliseconds(100)
                       : 10 * done / poses_ == tenths_) {
    return;
  }
  shown_ = now;
  tenths_ = 10 * done / poses_;
  line_.show(fmt::format("{:3d} %  {} of {} poses  cost {:.6g}  {:.0f}/s", 100 * done / poses_,
                         done, poses_, cost, static_cast<double>(done) / seconds_since(start_)));
}

}  // namespace hybrid
