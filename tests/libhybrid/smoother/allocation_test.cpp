// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Every allocation of an update fails once, and the smoother is as it was before.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/support/changing_world.h"

namespace {

std::atomic<long> allocations_left{-1};  // negative: none fails

void* allocate(std::size_t size) {
  if (allocations_left >= 0 && allocations_left-- == 0) throw std::bad_alloc();
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) {
  return allocate(size);
}
void* operator new[](std::size_t size) {
  return allocate(size);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  if (allocations_left >= 0 && allocations_left-- == 0) return nullptr;
  return std::malloc(size == 0 ? 1 : size);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace hybrid {
namespace {

using testing::ChangingWorld;
using testing::state;

/// Lets the n-th allocation from now on fail in a call; returns whether the call came to its end.
template <class Call>
bool with_failing_allocation(long n, const Call& call) {
  allocations_left = n;
  try {
    call();
  } catch (const std::bad_alloc&) {
    allocations_left = -1;
    return false;
  }
  const bool reached = allocations_left < 0;
  allocations_left = -1;
  return !reached;
}

TEST(Allocation, WhereOneFailsTheSmootherIsAsItWasBefore) {
  int failures = 0;
  for (int seed = 1; seed <= 3; ++seed) {
    ChangingWorld world(seed);
    IncrementalSmoother smoother;
    for (int k = 0; k < 12; ++k) {
      const std::vector<double> before = state(smoother);
      for (long n = 0;; ++n) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", step " + std::to_string(k) +
                     ", allocation " + std::to_string(n));
        IncrementalSmoother trial = smoother;
        ChangingWorld other = world;
        if (with_failing_allocation(n, [&] { other.step(trial); })) break;
        ++failures;
        if (trial.graph().size() != smoother.graph().size()) continue;  // it failed in the world
        ASSERT_EQ(state(trial), before);
        if (n % 7 != 0) continue;
        other = world;
        IncrementalSmoother twin = smoother;
        ChangingWorld twin_world = world;
        other.step(trial);
        twin_world.step(twin);
        ASSERT_EQ(state(trial), state(twin));
      }
      world.step(smoother);
    }
  }
  EXPECT_GT(failures, 3000);
}

}  // namespace
}  // namespace hybrid
