// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <vector>

#include "libhybrid/core/values.h"

namespace HYBRID_API hybrid {

/// Values whose changes since the last `commit` can be rolled back, at the cost of what changed.
/// Variables that are removed stay until the commit.
class JournaledValues {
 public:
  const Values& get() const { return values_; }
  const Values* operator->() const { return &values_; }

  void insert(Key key, VariableType type, const double* x) {
    if (values_.contains(key)) throw Error("variable " + to_string(key) + " exists already");
    inserted_.push_back(key);
    values_.insert(key, type, x);
    const int slot = values_.slot(key);
    if (slot >= static_cast<int>(saved_.size())) saved_.resize(slot + 1, 0);
    saved_[slot] = epoch_;
  }
  /// Variables that came since the last commit.
  const std::vector<Key>& inserted() const { return inserted_; }
  /// Slots of others that may have changed since then.
  const std::vector<int>& edited() const { return slots_; }
  void remove(Key key) { removed_.push_back(key); }
  bool is_removed(Key key) const {
    return std::find(removed_.begin(), removed_.end(), key) != removed_.end();
  }

  /// The numbers of a variable, to be changed.
  double* edit(int slot) {
    double* x = values_.data(slot);
    if (saved_[slot] != epoch_) {
      numbers_.insert(numbers_.end(), x, x + values_.type(slot).size);
      slots_.push_back(slot);
      saved_[slot] = epoch_;
    }
    return x;
  }

  void commit() {
    for (Key key : removed_) values_.erase(key);
    start_epoch();
  }
  void roll_back() {
    const double* x = numbers_.data();
    for (int slot : slots_) {
      std::copy_n(x, values_.type(slot).size, values_.data(slot));
      x += values_.type(slot).size;
    }
    for (auto key = inserted_.rbegin(); key != inserted_.rend(); ++key) {
      if (values_.contains(*key)) values_.take_back(*key, committed_slots_);
    }
    start_epoch();
  }

 private:
  void start_epoch() {
    ++epoch_;
    committed_slots_ = values_.slot_count();
    inserted_.clear();
    removed_.clear();
    slots_.clear();
    numbers_.clear();
  }

  Values values_;
  unsigned epoch_ = 1;
  std::vector<unsigned> saved_;  // by slot: the epoch in which it was last saved
  int committed_slots_ = 0;
  std::vector<Key> inserted_, removed_;
  std::vector<int> slots_;       // of variables that changed, and
  std::vector<double> numbers_;  // what they were before, one after the other
};

}  // namespace hybrid
