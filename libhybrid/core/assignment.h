// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <unordered_map>

#include "libhybrid/core/error.h"
#include "libhybrid/core/key.h"

namespace HYBRID_API hybrid {

/// The values of discrete variables, D in the paper.
class Assignment {
 public:
  /// Value of a variable; throws Error if it has none.
  int at(Key key) const {
    const auto it = values_.find(key);
    if (it == values_.end()) throw Error("discrete variable " + to_string(key) + " has no value");
    return it->second;
  }
  /// -1 for a variable without a value.
  int find(Key key) const {
    const auto it = values_.find(key);
    return it == values_.end() ? -1 : it->second;
  }
  bool contains(Key key) const { return values_.count(key) != 0; }
  void set(Key key, int value) { values_[key] = value; }
  void erase(Key key) { values_.erase(key); }
  std::size_t size() const { return values_.size(); }

  auto begin() const { return values_.begin(); }
  auto end() const { return values_.end(); }

  friend bool operator==(const Assignment& a, const Assignment& b) {
    return a.values_ == b.values_;
  }

 private:
  std::unordered_map<Key, int> values_;
};

}  // namespace hybrid
