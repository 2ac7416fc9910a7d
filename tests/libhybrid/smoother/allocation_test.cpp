// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Every allocation of an update fails once, and the smoother is as it was before.
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <new>

#include "libhybrid/marginals/continuous.h"
#include "tests/support/changing_world.h"

namespace {

std::atomic<long> allocations_left{-1};  // negative: none fails

[[maybe_unused]] bool no_memory() {
  if (allocations_left < 0 || allocations_left-- != 0) return false;
  errno = ENOMEM;
  return true;
}

}  // namespace

// Those of new as well as those of Eigen. Sanitizers have allocations of their own: nothing fails.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSome = false;
#else
constexpr bool kSome = true;
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_realloc(void*, std::size_t);
void* malloc(std::size_t size) noexcept {
  return no_memory() ? nullptr : __libc_malloc(size);
}
void* realloc(void* old, std::size_t size) noexcept {
  return no_memory() ? nullptr : __libc_realloc(old, size);
}
}
#endif

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
  if (!kSome) GTEST_SKIP() << "sanitizers take the place of malloc";
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

/// Reports end with a list of what has changed: it is made while all can still be taken back.
TEST(Allocation, WhereOneFailsInTheReportTheUpdateIsTakenBack) {
  if (!kSome) GTEST_SKIP() << "sanitizers take the place of malloc";
  ChangingWorld world(1);
  IncrementalSmoother smoother;
  for (int k = 0; k < 6; ++k) world.step(smoother);
  const std::vector<double> before = state(smoother);
  Delta delta;
  delta.values.insert(testing::pose(6), SE2());
  delta.continuous.push_back(testing::between(5, 6, SE2(), 0.1));
  int failures = 0;
  for (;; ++failures) {
    IncrementalSmoother trial = smoother;
    bool taken = false;  // also where a sort does without memory of its own
    const auto update = [&] {
      trial.update(delta);
      taken = true;
    };
    if (with_failing_allocation(failures, update)) break;
    if (taken) continue;
    ASSERT_EQ(state(trial), before) << "allocation " << failures;
  }
  EXPECT_GT(failures, 20);
}

/// Eigen frees what a matrix had before it allocates, and once more where that fails: no matrix may
/// be resized that has something.
TEST(Allocation, WhereOneFailsACovarianceIsGivenUp) {
  if (!kSome) GTEST_SKIP() << "sanitizers take the place of malloc";
  ChangingWorld world(1);
  IncrementalSmoother smoother;
  for (int k = 0; k < 12; ++k) world.step(smoother);
  std::vector<Key> keys = smoother.values().keys();
  const ContinuousMarginals marginals(smoother.graph(), smoother.estimate());
  int failures = 0;
  const auto expect_given_up = [&](const auto& covariance) {
    const Eigen::MatrixXd expected = covariance();
    for (long n = 0;; ++n) {
      Eigen::MatrixXd out;
      if (with_failing_allocation(n, [&] { out = covariance(); })) {
        EXPECT_EQ(out, expected);
        return;
      }
      ++failures;
    }
  };
  expect_given_up([&] { return marginals.joint_covariance(keys); });
  expect_given_up([&] { return smoother.joint_covariance(keys); });
  EXPECT_GT(failures, 50);
}

}  // namespace
}  // namespace hybrid
