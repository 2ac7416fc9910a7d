// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace hybrid {

/// Means of a correlated sequence of vectors, with standard errors from batch means; the batches
/// grow with the number of vectors.
class BatchMeans {
 public:
  void add(const std::vector<double>& sample);
  std::vector<double> mean() const;
  /// Infinite while there are fewer than eight batches.
  std::vector<double> standard_error() const;

 private:
  std::vector<std::vector<double>> batches_;  // sums, all of `length_` samples
  std::vector<double> open_;                  // sum of the unfinished batch
  int length_ = 1;
  int count_ = 0;  // samples in the unfinished batch
};

struct GibbsOptions {
  double standard_error = 0.01;  ///< sampling ends once no mean has a larger one
  int max_sweeps = 2000;
  std::uint64_t seed = 1;
};

/// The discrete variables to sample and their distribution.
struct GibbsModel {
  std::vector<int> cardinalities;
  /// Variables that are drawn together, besides neighbours in the order given.
  std::vector<std::pair<int, int>> pairs;
  /// log of the unnormalised probability of joint values.
  std::function<double(const std::vector<int>& values)> log_weight;
  /// Further numbers to average over the joint values; may be empty.
  std::function<std::vector<double>(const std::vector<int>& values)> expectations;
};

/// Block Gibbs sampling from `start`, two variables at a time given all others. Returns the means
/// of the probabilities of each variable's values given the others (Rao-Blackwell), variable by
/// variable, followed by those of the expectations. The same seed gives the same result on every
/// machine.
BatchMeans sample_marginals(const GibbsModel& model, std::vector<int> start,
                            const GibbsOptions& options);

}  // namespace hybrid
