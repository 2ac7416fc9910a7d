// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Random numbers that are the same with every standard library: only the generator is taken from
/// it, which the standard fixes bit by bit; the distributions are ours.
class Random {
 public:
  explicit Random(std::uint64_t seed) : generator_(seed) {}

  /// Uniform in [0, 1), 53 bits.
  double uniform();
  double uniform(double min, double max) { return min + (max - min) * uniform(); }
  /// Gaussian with mean 0, by Marsaglia's polar method.
  double normal(double sigma = 1.0);
  /// Poisson, by multiplying uniforms: meant for small means.
  int poisson(double mean);
  /// Index i with probability weights[i] / sum.
  std::size_t index(const std::vector<double>& weights);

 private:
  std::mt19937_64 generator_;
};

/// `value` rounded to a multiple of 2^-30, so that results do not hang on the last bit of sin() and
/// its like, which varies between processors.
double quantised(double value);

}  // namespace hybrid
