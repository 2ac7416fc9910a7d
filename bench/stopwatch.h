// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <chrono>
#include <ctime>
#include <numeric>
#include <vector>

#include "libhybrid/core/elapsed.h"

namespace hybrid::bench {

/// Wall time, and processor time of this process, which is more reliable on a busy machine.
struct Time {
  double wall = 0.0;  ///< [s]
  double cpu = 0.0;   ///< [s]
};

class Stopwatch {
 public:
  Stopwatch() : wall_(std::chrono::steady_clock::now()), cpu_(cpu_now()) {}
  Time elapsed() const { return {seconds_since(wall_), cpu_now() - cpu_}; }

 private:
  static double cpu_now() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }

  std::chrono::steady_clock::time_point wall_;
  double cpu_;
};

/// Times of many steps [s].
struct Distribution {
  double total = 0.0, mean = 0.0, p50 = 0.0, p95 = 0.0, p99 = 0.0, max = 0.0;
};

inline Distribution distribution(std::vector<double> seconds) {
  Distribution d;
  if (seconds.empty()) return d;
  std::sort(seconds.begin(), seconds.end());
  const auto quantile = [&](double q) {
    return seconds[std::min(seconds.size() - 1,
                            static_cast<std::size_t>(q * static_cast<double>(seconds.size())))];
  };
  d.total = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  d.mean = d.total / static_cast<double>(seconds.size());
  d.p50 = quantile(0.5);
  d.p95 = quantile(0.95);
  d.p99 = quantile(0.99);
  d.max = seconds.back();
  return d;
}

}  // namespace hybrid::bench
