// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/detections/detection_model.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hybrid {
namespace {

/// By hand: with a prior of five detections and five misses, the first look misses with 5/10, the
/// second one with 6/11.
TEST(DetectionModel, LooksHaveTheProbabilitiesOfABetaBinomial) {
  const DetectionModel even(0.5);
  EXPECT_NEAR(even.log_probability(0, 2), std::log(5.0 / 10 * 6 / 11), 1e-12);
  EXPECT_NEAR(even.log_probability(1, 2), std::log(5.0 / 10 * 5 / 11), 1e-12);
  EXPECT_EQ(even.log_probability(0, 0), 0);
}

// The mean of p under its density is that of all things.
TEST(DetectionModel, ItsDensityHasTheMeanOfAllThings) {
  const DetectionModel rare(0.3);
  double weights = 0, sum = 0;
  for (int node = 0; node < 1000; ++node) {
    const double p = (node + 0.5) / 1000, weight = std::exp(rare.log_density(p));
    weights += weight;
    sum += weight * p;
  }
  EXPECT_NEAR(sum / weights, 0.3, 1e-5);
}

}  // namespace
}  // namespace hybrid
