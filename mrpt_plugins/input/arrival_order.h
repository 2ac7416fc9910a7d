// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <utility>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Things that arrive in any order, given in that of their time stamps as far as they arrive
/// within a window. Equal stamps keep the order of arrival. What is later than the window comes
/// out behind what was given before it.
template <class Thing>
class ArrivalOrder {
 public:
  /// `window` [s] of stamps that may be overtaken; 0: the order of arrival.
  explicit ArrivalOrder(double window) : window_(window) {}

  void add(double time, Thing thing) {
    if (!newest_ || time > *newest_) newest_ = time;
    waiting_.emplace(time, std::move(thing));
  }

  /// The next thing that nothing within the window can come before; `all`: that is not awaited.
  std::optional<Thing> next(bool all = false) {
    if (waiting_.empty()) return std::nullopt;
    const auto first = waiting_.begin();
    const bool full = waiting_.size() > kMost;
    if (!all && !full && first->first > *newest_ - window_) return std::nullopt;
    Thing out = std::move(first->second);
    waiting_.erase(first);
    return out;
  }

  /// The latest stamp so far [s].
  const std::optional<double>& newest() const { return newest_; }

 private:
  static constexpr std::size_t kMost = 4096;  // things in memory

  double window_;
  std::multimap<double, Thing> waiting_;
  std::optional<double> newest_;
};

}  // namespace hybrid
