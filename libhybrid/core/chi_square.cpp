// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/chi_square.h"

#include <cmath>
#include <string>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

/// Probability that the sum exceeds x >= 0, accurate in the tail: the recursion of the incomplete
/// gamma function from one or two degrees upwards.
double upper_tail(double x, int degrees) {
  const double half = 0.5 * x;
  double a = degrees % 2 == 0 ? 1.0 : 0.5;
  double tail = degrees % 2 == 0 ? std::exp(-half) : std::erfc(std::sqrt(half));
  if (half == 0.0) return 1.0;
  for (; a < 0.5 * degrees - 0.25; a += 1.0) {
    tail += std::exp(a * std::log(half) - half - std::lgamma(a + 1.0));
  }
  return tail;
}

void check_degrees(int degrees) {
  if (degrees < 1) {
    throw Error("a chi-square distribution needs at least 1 degree of freedom, got " +
                std::to_string(degrees));
  }
}

}  // namespace

double chi_square_probability(double x, int degrees) {
  check_degrees(degrees);
  if (std::isnan(x)) throw Error("the chi-square probability of a value that is not a number");
  return x <= 0.0 ? 0.0 : 1.0 - upper_tail(x, degrees);
}

double chi_square_quantile(double probability, int degrees) {
  check_degrees(degrees);
  if (!(probability >= 0.0) || !(probability < 1.0)) {
    throw Error("the probability of a chi-square quantile must be in [0, 1), got " +
                std::to_string(probability));
  }
  const double tail = 1.0 - probability;
  double low = 0.0;
  double high = 1.0;
  while (upper_tail(high, degrees) > tail) high *= 2.0;
  while (high - low > 1e-14 * high) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    (upper_tail(middle, degrees) > tail ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace hybrid
