// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>
#include <limits>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A running sum of costs that come and go. Those that are not finite (impossible values) are
/// counted, so that the sum is finite again once they are gone, and rounding is compensated, so
/// that a huge cost leaves nothing behind (Neumaier).
class CostSum {
 public:
  void add(double cost) { std::isfinite(cost) ? accumulate(cost) : void(++infinite_); }
  void subtract(double cost) { std::isfinite(cost) ? accumulate(-cost) : void(--infinite_); }
  double value() const {
    return infinite_ > 0 ? std::numeric_limits<double>::infinity() : sum_ + rest_;
  }

 private:
  void accumulate(double x) {
    const double sum = sum_ + x;
    rest_ += std::abs(sum_) >= std::abs(x) ? (sum_ - sum) + x : (x - sum) + sum_;
    sum_ = sum;
  }

  double sum_ = 0.0;
  double rest_ = 0.0;
  int infinite_ = 0;
};

}  // namespace hybrid
