// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <vector>

#include "libhybrid/core/values.h"

namespace HYBRID_API hybrid {

/// Values whose changes since the last `commit`, or since a mark after it, can be rolled back, at
/// the cost of what changed.
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
  std::vector<int> edited() const {
    std::vector<int> slots = slots_;
    if (!marked_) return slots;
    std::sort(slots.begin(), slots.end());
    slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
    return slots;
  }
  void remove(Key key) { removed_.push_back(key); }
  bool is_removed(Key key) const {
    return std::find(removed_.begin(), removed_.end(), key) != removed_.end();
  }

  /// The numbers of a variable, to be changed.
  double* edit(int slot) {
    double* x = values_.data(slot);
    if (saved_[slot] != epoch_) {
      // Both or neither where memory is short: what is last is restored first.
      if (slots_.size() == slots_.capacity()) slots_.reserve(2 * slots_.size() + 1);
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
  struct Mark {
    std::size_t edited = 0, inserted = 0, removed = 0;
    int slots = 0;
  };
  Mark mark() {
    ++epoch_;
    marked_ = true;
    return {slots_.size(), inserted_.size(), removed_.size(), values_.slot_count()};
  }
  void roll_back() { roll_back(base_); }
  void roll_back(const Mark& mark) {
    for (; slots_.size() > mark.edited; slots_.pop_back()) {
      const int size = values_.type(slots_.back()).size;
      std::copy_n(numbers_.end() - size, size, values_.data(slots_.back()));
      numbers_.resize(numbers_.size() - static_cast<std::size_t>(size));
    }
    for (; inserted_.size() > mark.inserted; inserted_.pop_back()) {
      if (values_.contains(inserted_.back())) values_.take_back(inserted_.back(), mark.slots);
    }
    removed_.resize(mark.removed);
    ++epoch_;
  }

 private:
  void start_epoch() {
    ++epoch_;
    base_ = {0, 0, 0, values_.slot_count()};
    marked_ = false;
    inserted_.clear();
    removed_.clear();
    slots_.clear();
    numbers_.clear();
  }

  Values values_;
  unsigned epoch_ = 1;
  std::vector<unsigned> saved_;  // by slot: the epoch in which it was last saved
  Mark base_;                    // of the last commit
  bool marked_ = false;          // since then
  std::vector<Key> inserted_, removed_;
  std::vector<int> slots_;       // of variables that changed, and
  std::vector<double> numbers_;  // what they were before, one after the other
};

}  // namespace hybrid
