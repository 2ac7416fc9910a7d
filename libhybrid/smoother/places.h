// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "libhybrid/core/values.h"

namespace HYBRID_API hybrid {

/// Where some variables are: their numbers, one after the other.
struct Places {
  std::vector<int> slots;
  std::vector<double> numbers;

  void append(int slot, const double* x, int size) {
    slots.push_back(slot);
    numbers.insert(numbers.end(), x, x + size);
  }
};

Places places_of(const std::vector<int>& slots, const Values& values);

/// Those, and where the variables are in others that it does not have.
Places with_others(const Places& place, const Places& others, const Values& values);

/// The way from some places to the values, in the tangents of the places.
std::vector<double> way_from(const Places& start, const Values& values);

/// Where variables were that have moved, before they did.
class MovedVariables {
 public:
  const Places& before() const { return before_; }

  /// Forgets them. Slots from now on are below `slots`.
  void start(int slots) {
    before_.slots.clear();
    before_.numbers.clear();
    ++now_;
    noted_.resize(std::max(noted_.size(), static_cast<std::size_t>(slots)));
  }
  /// Called before a variable moves.
  void note(int slot, const Values& values) {
    if (noted_[slot] == now_) return;
    noted_[slot] = now_;
    before_.append(slot, values.data(slot), values.type(slot).size);
  }

 private:
  Places before_;
  std::vector<unsigned> noted_;  // by slot: when it was last noted
  unsigned now_ = 0;
};

}  // namespace hybrid
