// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-experiment/progress.h"

#include "libhybrid/core/elapsed.h"

namespace hybrid {

void Progress::ended(const std::string& what) {
  ++done_;
  const std::size_t twentieths = 20 * done_ / todo_;
  if (line_.terminal() || twentieths != twentieths_) show(what);
  twentieths_ = twentieths;
}

void Progress::show(const std::string& what) {
  const double left =
      seconds_since(start_) / static_cast<double>(done_) * static_cast<double>(todo_ - done_);
  line_.show(fmt::format("{:3d} %  {} of {} trials  about {:.0f} s left  {}", 100 * done_ / todo_,
                         done_, todo_, left, what));
}

}  // namespace hybrid
