// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <atomic>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "libhybrid/factors/factor.h"

namespace hybrid::testing {

/// Counts down the evaluations of fragile factors, from any thread; the one that reaches zero
/// throws.
class Fuse {
 public:
  void arm(int uses) { left_ = uses; }
  void disarm() { left_ = 0; }
  void burn() {
    int left = left_;
    while (left > 0 && !left_.compare_exchange_weak(left, left - 1)) {
    }
    if (left == 1) throw std::domain_error("a factor of the user threw");
  }

 private:
  std::atomic<int> left_{0};
};

/// A wrapper of a factor that throws when the count of the fuse reaches zero.
class FragileFactor : public ContinuousFactor {
 public:
  FragileFactor(ContinuousFactorPtr factor, std::shared_ptr<Fuse> fuse)
      : ContinuousFactor(factor->keys(), factor->types(), factor->rows()),
        factor_(std::move(factor)),
        fuse_(std::move(fuse)) {}

  double cost(const double* const* x) const override {
    fuse_->burn();
    return factor_->cost(x);
  }
  double linearize(const double* const* x, double* r, double* J) const override {
    fuse_->burn();
    return factor_->linearize(x, r, J);
  }
  double log_normalizer() const override { return factor_->log_normalizer(); }
  std::string name() const override { return "fragile"; }

 private:
  ContinuousFactorPtr factor_;
  std::shared_ptr<Fuse> fuse_;
};

}  // namespace hybrid::testing
