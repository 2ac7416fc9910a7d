// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <numeric>
#include <string>
#include <vector>

namespace hybrid::bench {

/// A CSV of step time over graph size, which plot-growth draws.
constexpr const char* kGrowthHeader = "graph,poses,cpu_us\n";

constexpr int kGrowthBlocks = 40;  // of steps, of which it has the means

/// Mean times [s] of blocks of consecutive steps as rows of the CSV.
inline std::string growth_rows(const std::string& name, const std::vector<double>& cpu) {
  std::string rows;
  for (int block = 0; block < kGrowthBlocks; ++block) {
    const std::size_t begin = cpu.size() * block / kGrowthBlocks,
                      end = cpu.size() * (block + 1) / kGrowthBlocks;
    if (begin == end) continue;
    const double sum = std::accumulate(cpu.begin() + begin, cpu.begin() + end, 0.0);
    rows += name + "," + std::to_string(end) + "," +
            std::to_string(1e6 * sum / double(end - begin)) + "\n";
  }
  return rows;
}

}  // namespace hybrid::bench
