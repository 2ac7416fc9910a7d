// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/detail/gibbs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace hybrid {
namespace {

constexpr std::size_t kMostBatches = 32;
constexpr std::size_t kLeastBatches = 8;
constexpr int kLeastSweeps = 32;
/// Larger pairs are drawn one variable at a time.
constexpr int kLargestPair = 64;

class Sampler {
 public:
  Sampler(const GibbsModel& model, std::vector<int> start, std::uint64_t seed)
      : model_(model), values_(std::move(start)), engine_(seed) {
    for (int cardinality : model.cardinalities) {
      first_.push_back(size_);
      size_ += cardinality;
    }
    const int n = static_cast<int>(values_.size());
    for (int i = 0; i + 1 < n; ++i) add_block(i, i + 1);
    for (const auto& [a, b] : model.pairs) {
      if (std::abs(a - b) > 1) add_block(a, b);
    }
    if (n == 1) blocks_.push_back({0});
  }

  /// Draws every block once. Returns the probabilities given the others, and the expectations.
  std::vector<double> sweep() {
    std::vector<double> sum(size_, 0.0);
    std::vector<double> count(values_.size(), 0.0);
    for (const std::vector<int>& block : blocks_) draw(block, sum, count);
    for (std::size_t v = 0; v < values_.size(); ++v) {
      for (int k = 0; k < model_.cardinalities[v]; ++k) sum[first_[v] + k] /= count[v];
    }
    if (model_.expectations) {
      const std::vector<double> more = model_.expectations(values_);
      sum.insert(sum.end(), more.begin(), more.end());
    }
    return sum;
  }

 private:
  void add_block(int a, int b) {
    if (model_.cardinalities[a] * model_.cardinalities[b] <= kLargestPair) {
      blocks_.push_back({a, b});
    } else {
      blocks_.push_back({a});
      blocks_.push_back({b});
    }
  }

  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }

  void draw(const std::vector<int>& block, std::vector<double>& sum, std::vector<double>& count) {
    const std::vector<int> before = values_;
    weights_.clear();
    double most = -std::numeric_limits<double>::infinity();
    do {
      weights_.push_back(model_.log_weight(values_));
      most = std::max(most, weights_.back());
    } while (next(block, before));
    if (!std::isfinite(most)) {  // every joint value is impossible: keep the present one
      values_ = before;
      for (int v : block) {
        sum[first_[v] + values_[v]] += 1.0;
        count[v] += 1.0;
      }
      return;
    }
    double total = 0.0;
    for (double& w : weights_) total += w = std::exp(w - most);
    double left = uniform() * total;
    std::vector<int> drawn = before;
    bool open = true;
    for (double w : weights_) {
      for (int v : block) sum[first_[v] + values_[v]] += w / total;
      left -= w;
      if (open && left < 0.0) {
        drawn = values_;
        open = false;
      }
      next(block, before);
    }
    values_ = std::move(drawn);
    for (int v : block) count[v] += 1.0;
  }

  /// Advances a block to its next joint value, cyclically; false when it is back at `before`.
  bool next(const std::vector<int>& block, const std::vector<int>& before) {
    for (int v : block) {
      values_[v] = (values_[v] + 1) % model_.cardinalities[v];
      if (values_[v] != before[v]) return true;
    }
    return false;
  }

  const GibbsModel& model_;
  std::vector<int> values_;
  std::mt19937_64 engine_;
  std::vector<int> first_;  // by variable: index in the means
  int size_ = 0;
  std::vector<std::vector<int>> blocks_;
  std::vector<double> weights_;
};

}  // namespace

void BatchMeans::add(const std::vector<double>& sample) {
  if (open_.empty()) open_.assign(sample.size(), 0.0);
  for (std::size_t i = 0; i < sample.size(); ++i) open_[i] += sample[i];
  if (++count_ < length_) return;
  batches_.push_back(std::move(open_));
  open_.clear();
  count_ = 0;
  if (batches_.size() < kMostBatches) return;
  for (std::size_t b = 0; b < kMostBatches / 2; ++b) {
    for (std::size_t i = 0; i < batches_[b].size(); ++i) {
      batches_[b][i] = batches_[2 * b][i] + batches_[2 * b + 1][i];
    }
  }
  batches_.resize(kMostBatches / 2);
  length_ *= 2;
}

std::vector<double> BatchMeans::mean() const {
  std::vector<double> mean = open_;
  if (mean.empty() && !batches_.empty()) mean.assign(batches_[0].size(), 0.0);
  for (const std::vector<double>& batch : batches_) {
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += batch[i];
  }
  const double samples = static_cast<double>(batches_.size()) * length_ + count_;
  for (double& m : mean) m /= samples;
  return mean;
}

std::vector<double> BatchMeans::standard_error() const {
  const std::vector<double> mean = this->mean();
  const double n = static_cast<double>(batches_.size());
  std::vector<double> error(mean.size(), 0.0);
  for (std::size_t i = 0; i < mean.size(); ++i) {
    for (const std::vector<double>& batch : batches_) {
      error[i] += std::pow(batch[i] / length_ - mean[i], 2);
    }
    error[i] = batches_.size() < kLeastBatches ? std::numeric_limits<double>::infinity()
                                               : std::sqrt(error[i] / (n * (n - 1.0)));
  }
  return error;
}

BatchMeans sample_marginals(const GibbsModel& model, std::vector<int> start,
                            const GibbsOptions& options) {
  Sampler sampler(model, std::move(start), options.seed);
  BatchMeans means;
  for (int sweep = 1; sweep <= std::max(options.max_sweeps, kLeastSweeps); ++sweep) {
    means.add(sampler.sweep());
    if (sweep < kLeastSweeps || (sweep & (sweep - 1)) != 0) continue;  // at powers of two
    const std::vector<double> error = means.standard_error();
    if (*std::max_element(error.begin(), error.end()) <= options.standard_error) break;
  }
  return means;
}

}  // namespace hybrid
