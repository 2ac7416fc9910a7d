// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/switching/markov.h"

#include <gtest/gtest.h>

#include <string>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

std::string message_of(const MarkovChain& chain) {
  try {
    check(chain);
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

TEST(MarkovChain, RowsMustSumToOne) {
  MarkovChain chain = sticky_chain(3, 0.8);
  EXPECT_EQ(message_of(chain), "");
  chain.transition(1, 2) = 0.3;
  EXPECT_NE(message_of(chain).find("row 2 of the transition matrix must sum to 1, its sum is 1.2"),
            std::string::npos)
      << message_of(chain);
  EXPECT_THROW(chain_tables(chain, {{Key('m', 0), 3}, {Key('m', 1), 3}}), Error);
  EXPECT_THROW(chain_step(chain, {Key('m', 0), 3}, {Key('m', 1), 3}), Error);
}

TEST(MarkovChain, RejectsWhatIsNoDistribution) {
  MarkovChain chain = sticky_chain(2, 0.5);
  chain.initial << 1.5, -0.5;
  EXPECT_NE(message_of(chain).find("initial distribution"), std::string::npos);
  chain = sticky_chain(2, 0.5);
  chain.transition(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message_of(chain).find("row 1"), std::string::npos);
  chain = sticky_chain(2, 0.5);
  chain.transition.resize(1, 2);
  EXPECT_NE(message_of(chain).find("must be 2 x 2"), std::string::npos);
  EXPECT_THROW(sticky_chain(0, 0.9), Error);
  EXPECT_THROW(sticky_chain(2, 1.5), Error);
  EXPECT_THROW(chain_tables(sticky_chain(2, 0.9), {{Key('m', 0), 3}}), Error);
}

TEST(MarkovChain, LearnsFromCounts) {
  MarkovCounts counts(2);
  counts.starts << 1.0, 0.0;
  counts.changes << 7.0, 1.0, 0.0, 4.0;
  const MarkovChain chain = counts.chain(1.0);
  EXPECT_DOUBLE_EQ(chain.initial[0], 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(chain.transition(0, 1), 0.2);
  EXPECT_DOUBLE_EQ(chain.transition(1, 0), 1.0 / 6.0);
}

}  // namespace
}  // namespace hybrid
