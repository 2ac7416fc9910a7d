// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "mrpt_plugins/mapping/closure_factors.h"

#include <gtest/gtest.h>

#include <memory>

#include "libhybrid/factors/prior.h"

namespace hybrid {
namespace {

bool add_factor(std::size_t, Contribution& out) {
  out.delta.continuous.push_back(std::make_shared<Prior<SE2>>(Key('x', 0), SE2(), Noise::unit(3)));
  return true;
}

/// What is asked of the map for one closure, with the answer to come.
Contribution ask(ClosureFactors& factors, bool accepted) {
  Contribution out;
  factors.follow({accepted}, add_factor, true, out);
  return out;
}

// A map that refuses a contribution has neither what was to come nor lost what was to leave.
TEST(ClosureFactors, AskAgainForWhatTheMapRefused) {
  ClosureFactors factors;
  EXPECT_EQ(ask(factors, true).delta.continuous.size(), 1U);
  factors.forget();
  EXPECT_FALSE(factors.has(0));
  EXPECT_EQ(ask(factors, true).delta.continuous.size(), 1U);
  Outcome outcome;
  const Handle handle{FactorKind::kContinuous, 7, 3};
  outcome.handles.continuous = {handle};
  factors.applied(outcome);
  EXPECT_TRUE(factors.has(0));
  EXPECT_TRUE(ask(factors, true).delta.continuous.empty());

  for (int i = 0; i < 2; ++i) {
    const Contribution leaves = ask(factors, false);
    ASSERT_EQ(leaves.delta.remove.size(), 1U);
    EXPECT_TRUE(leaves.delta.remove.front() == handle);
    factors.forget();
    EXPECT_TRUE(factors.has(0));
  }
  ask(factors, false);
  factors.applied({});
  EXPECT_FALSE(factors.has(0));
}

}  // namespace
}  // namespace hybrid
