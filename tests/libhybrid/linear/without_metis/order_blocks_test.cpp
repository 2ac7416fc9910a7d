// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A program of its own: here CHOLMOD is as if built without METIS.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "libhybrid/linear/block_pattern.h"

namespace {

constexpr int kNotInstalled = -1;  // CHOLMOD_NOT_INSTALLED
int calls = 0;

}  // namespace

extern "C" {

int cholmod_error(int status, const char* file, int line, const char* message, void* common);

// In place of the library's, which cholmod_analyze calls for nested dissection.
int cholmod_metis(void*, int*, std::size_t, int, int*, void* common) {
  ++calls;
  cholmod_error(kNotInstalled, __FILE__, __LINE__, "METIS is not installed", common);
  return 0;
}
}

namespace hybrid {
namespace {

// A chain makes a tall elimination tree, and a dense graph an expensive one: both ask for METIS.
TEST(OrderBlocks, DoesWithoutMetis) {
  for (bool dense : {false, true}) {
    const int n = dense ? 60 : 1000;
    BlockPattern pattern;
    pattern.dims.assign(n, 6);
    for (int i = 0; i < n; ++i) {
      for (int j = i + 1; j < (dense ? n : std::min(n, i + 2)); ++j)
        pattern.edges.emplace_back(i, j);
    }
    calls = 0;
    const BlockOrdering ordering = order_blocks(pattern);
    EXPECT_GT(calls, 0);
    std::vector<int> order = ordering.order, all(n);
    std::iota(all.begin(), all.end(), 0);
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order, all);
    EXPECT_EQ(ordering.supernodes.back(), n);
  }
}

}  // namespace
}  // namespace hybrid
