// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Sets of closures of which at most one is true, such as all poses that one search found. Those
/// that were not added stand alone.
class Alternatives {
 public:
  /// The next closure, of the set of the closure `first`; alone if that is its own number. Throws
  /// Error for a closure that comes later.
  void add(std::size_t first) {
    const std::size_t closure = first_.size();
    if (first > closure) {
      throw Error("closure " + std::to_string(closure) + " is an alternative of closure " +
                  std::to_string(first) + ", which comes later");
    }
    if (first < closure) first = first_[first];
    first_.push_back(first);
    if (first == closure) return;
    std::vector<std::size_t>& set = sets_[first];
    if (set.empty()) set.push_back(first);
    set.push_back(closure);
  }
  /// Forgets all but the first closures.
  void resize(std::size_t count) {
    while (first_.size() > count) {
      const std::size_t first = first_.back();
      first_.pop_back();
      if (first == first_.size()) continue;
      std::vector<std::size_t>& set = sets_.at(first);
      set.pop_back();
      if (set.size() == 1) sets_.erase(first);
    }
  }

  std::size_t size() const { return first_.size(); }
  /// All closures of the set of a closure, in order; empty if it stands alone.
  const std::vector<std::size_t>& set_of(std::size_t closure) const {
    static const std::vector<std::size_t> alone;
    if (sets_.empty() || closure >= first_.size()) return alone;
    const auto found = sets_.find(first_[closure]);
    return found == sets_.end() ? alone : found->second;
  }
  /// Whether another of the set of a closure is accepted.
  template <class Accepted>
  bool exclude(std::size_t closure, const Accepted& accepted) const {
    for (const std::size_t other : set_of(closure)) {
      if (other != closure && accepted(other)) return true;
    }
    return false;
  }

 private:
  std::vector<std::size_t> first_;                        // by closure
  std::map<std::size_t, std::vector<std::size_t>> sets_;  // of several, by the first
};

}  // namespace hybrid
