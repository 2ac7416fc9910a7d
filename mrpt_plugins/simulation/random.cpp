// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/simulation/random.h"

#include <cmath>
#include <numeric>

namespace hybrid {

double Random::uniform() {
  return std::ldexp(static_cast<double>(generator_() >> 11U), -53);
}

double Random::normal(double sigma) {
  double u = 0, v = 0, square = 0;
  do {
    u = uniform(-1, 1);
    v = uniform(-1, 1);
    square = u * u + v * v;
  } while (square >= 1 || square == 0);
  return sigma * u * std::sqrt(-2 * std::log(square) / square);
}

int Random::poisson(double mean) {
  const double limit = std::exp(-mean);
  int count = 0;
  for (double product = uniform(); product > limit; product *= uniform()) ++count;
  return count;
}

std::size_t Random::index(const std::vector<double>& weights) {
  double rest = uniform() * std::accumulate(weights.begin(), weights.end(), 0.0);
  for (std::size_t i = 0; i + 1 < weights.size(); ++i) {
    rest -= weights[i];
    if (rest < 0) return i;
  }
  return weights.size() - 1;
}

double quantised(double value) {
  return std::ldexp(std::nearbyint(std::ldexp(value, 30)), -30);
}

}  // namespace hybrid
