// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/discrete/probabilities.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/discrete/inference.h"

namespace hybrid {
namespace {

const DiscreteKey kRain{{'r', 0}, 2}, kSprinkler{{'k', 0}, 2}, kGrass{{'g', 0}, 3};
const std::vector<double> kRains = {0.8, 0.2};
const std::vector<double> kSprinkles = {0.6, 0.4, 0.99, 0.01};    // by rain
const std::vector<double> kWet = {1.0, 0.0, 0.0, 0.1, 0.6, 0.3,   // by sprinkler and rain: dry,
                                  0.2, 0.5, 0.3, 0.0, 0.1, 0.9};  // damp, wet

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Probabilities, CostsAndPotentialsAreInverse) {
  for (double f : {1e-300, 1e-9, 0.25, 1.0, 3.0, 1e200}) {
    EXPECT_DOUBLE_EQ(to_cost(f), -std::log(f));
    EXPECT_NEAR(to_potential(to_cost(f)), f, 1e-12 * f);
  }
  EXPECT_EQ(to_cost(0.0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(to_potential(std::numeric_limits<double>::infinity()), 0.0);
  for (double bad : {-1e-9, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(to_cost(bad), Error);
  }
}

TEST(Probabilities, AConditionalHoldsTheProbabilityOfEachChildGivenItsParents) {
  const Table table = conditional_table(kGrass, {kSprinkler, kRain}, kWet);
  Assignment at;
  for (int s = 0; s < 2; ++s) {
    for (int r = 0; r < 2; ++r) {
      for (int g = 0; g < 3; ++g) {
        at.set(kSprinkler.key, s);
        at.set(kRain.key, r);
        at.set(kGrass.key, g);
        EXPECT_NEAR(to_potential(table.cost(at)), kWet[(2 * s + r) * 3 + g], 1e-15);
      }
    }
  }
}

// p(rain | grass) of a network, by summing over all joint values.
TEST(Probabilities, ANetworkOfConditionalsHasTheMarginalsOfItsEnumeration) {
  const Table rain = conditional_table(kRain, {}, kRains);
  const Table sprinkler = conditional_table(kSprinkler, {kRain}, kSprinkles);
  const Table grass = conditional_table(kGrass, {kSprinkler, kRain}, kWet);
  for (int seen = 0; seen < 3; ++seen) {
    std::vector<double> looked(3, 0.0);
    looked[seen] = 2.5;  // a potential, not normalised
    const Table look = potential_table({kGrass}, looked);
    double sum = 0.0, rained = 0.0;
    for (int r = 0; r < 2; ++r) {
      for (int s = 0; s < 2; ++s) {
        const double p = kRains[r] * kSprinkles[2 * r + s] * kWet[(2 * s + r) * 3 + seen];
        sum += p;
        if (r == 1) rained += p;
      }
    }
    const DiscreteMarginals marginals = discrete_marginals({&rain, &sprinkler, &grass, &look});
    EXPECT_NEAR(marginals.at(kRain.key)[1], rained / sum, 1e-12);
    EXPECT_NEAR(marginals.at(kGrass.key)[seen], 1.0, 1e-12);
  }
}

TEST(Probabilities, OfATableSumToOneHoweverLargeItsCosts) {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> p =
      to_probabilities(Table({kRain, kSprinkler}, {1e5, 1e5 + std::log(3.0), infinity, 1e9}));
  ASSERT_EQ(p.size(), 4u);
  EXPECT_NEAR(p[0], 0.75, 1e-10);
  EXPECT_NEAR(p[1], 0.25, 1e-10);
  EXPECT_EQ(p[2], 0.0);
  EXPECT_EQ(p[3], 0.0);
  const std::vector<double> joint =
      to_probabilities(conditional_table(kGrass, {kRain}, {0.5, 0.25, 0.25, 0.0, 0.5, 0.5}));
  EXPECT_NEAR(joint[0], 0.25, 1e-15);  // over both values of the parent
  EXPECT_NE(message_of([&] {
              to_probabilities(Table({kRain}, {infinity, infinity}));
            }).find("over r0 makes every joint value impossible"),
            std::string::npos);
}

TEST(Probabilities, APosteriorFollowsBayesHoweverSmallTheLikelihoods) {
  const std::vector<double> p = posterior({0.5, 0.25, 0.25}, {-1e4, -1e4 + std::log(4.0), -2e4});
  ASSERT_EQ(p.size(), 3u);
  EXPECT_NEAR(p[0], 1.0 / 3, 1e-10);
  EXPECT_NEAR(p[1], 2.0 / 3, 1e-10);
  EXPECT_EQ(p[2], 0.0);
  EXPECT_EQ(most_probable(p), 1);
  EXPECT_EQ(most_probable({0.4, 0.4, 0.2}), 0);
  EXPECT_EQ(most_probable({}), -1);
  EXPECT_TRUE(posterior({}, {}).empty());
  EXPECT_EQ(message_of([] {
              posterior({1.0}, {0.0, 0.0});
            }),
            "a prior of 1 values, likelihoods of 2");
}

TEST(Probabilities, ErrorsNameTheRow) {
  std::vector<double> wrong = kWet;
  wrong[9] = 0.2;  // sprinkler and rain
  const auto grass = [&] { conditional_table(kGrass, {kSprinkler, kRain}, wrong); };
  EXPECT_EQ(message_of(grass),
            "p(g0 | k0, r0), row of k0 = 1, r0 = 1: the probabilities sum to 1.200000; make them "
            "sum to 1");
  wrong[9] = -0.1;
  EXPECT_NE(message_of(grass).find("row of k0 = 1, r0 = 1: a probability must be finite"),
            std::string::npos);
  wrong.pop_back();
  EXPECT_EQ(message_of(grass), "p(g0 | k0, r0) needs 12 probabilities, got 11");
  EXPECT_NE(message_of([] {
              conditional_table(kRain, {}, {0.5, 0.4});
            }).find("of no parents"),
            std::string::npos);
  EXPECT_THROW(conditional_table(kRain, {kRain}, {1.0, 0.0, 0.0, 1.0}), Error);
  EXPECT_NE(message_of([] {
              potential_table({kRain}, {1.0, -2.0});
            }).find("over r0, entry 1"),
            std::string::npos);
}

}  // namespace
}  // namespace hybrid
