// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Random numbers that are the same with every standard library: the standard defines the generator
/// bit by bit, and the distributions are our own.
class Random {
 public:
  explicit Random(std::uint64_t seed) : generator_(seed) {}

  /// Uniform in [0, 1), 53 bits.
  double uniform();
  double uniform(double min, double max) { return min + (max - min) * uniform(); }
  /// Gaussian with mean 0, by Marsaglia's polar method.
  double normal(double sigma = 1.0);
  /// Poisson, by multiplying uniform numbers: for small means.
  int poisson(double mean);
  /// Index i with probability weights[i] / sum.
  std::size_t index(const std::vector<double>& weights);

 private:
  std::mt19937_64 generator_;
};

/// `value` rounded to a multiple of 2^-30, so that results do not depend on the last bit of sin()
/// and similar functions, which varies between processors.
double quantised(double value);

}  // namespace hybrid
