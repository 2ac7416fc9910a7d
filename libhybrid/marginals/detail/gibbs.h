// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace hybrid {

/// Means of vectors that come one after the other, correlated, with their standard errors from the
/// means of batches that grow with their number.
class BatchMeans {
 public:
  void add(const std::vector<double>& sample);
  std::vector<double> mean() const;
  /// Infinite while there are fewer than eight batches.
  std::vector<double> standard_error() const;

 private:
  std::vector<std::vector<double>> batches_;  // sums, all of `length_` samples
  std::vector<double> open_;                  // the sum of the batch under way
  int length_ = 1;
  int count_ = 0;  // samples in it
};

struct GibbsOptions {
  double standard_error = 0.01;  ///< sampling ends once no mean has a larger one
  int max_sweeps = 2000;
  std::uint64_t seed = 1;
};

/// What is sampled: discrete variables with some number of values each.
struct GibbsModel {
  std::vector<int> cardinalities;
  /// Variables that are drawn together, beside neighbours in the order given.
  std::vector<std::pair<int, int>> pairs;
  /// log of the unnormalised probability of joint values.
  std::function<double(const std::vector<int>& values)> log_weight;
  /// Further numbers to average over the joint values; may be empty.
  std::function<std::vector<double>(const std::vector<int>& values)> expectations;
};

/// Block Gibbs sampling from `start`, two variables at a time given all others. Averages the
/// probabilities of the values given the others (Rao-Blackwell), variable by variable, and behind
/// them the expectations. The same for the same seed on every machine.
BatchMeans sample_marginals(const GibbsModel& model, std::vector<int> start,
                            const GibbsOptions& options);

}  // namespace hybrid
