// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <vector>

#include "libhybrid/core/journal.h"
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
    saved_[slot] = numbers_.epoch();
  }
  /// Variables that came since the last commit.
  const std::vector<Key>& inserted() const { return inserted_; }
  /// Slots of others that may have changed since then.
  std::vector<int> edited() const {
    std::vector<int> slots;
    for (const auto& entry : numbers_.entries()) slots.push_back(entry.number);
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
    numbers_.save(slot, saved_[slot], x, values_.type(slot).size);
    return x;
  }

  void commit() {
    for (Key key : removed_) values_.erase(key);
    numbers_.commit();
    inserted_.clear();
    removed_.clear();
    marked_ = false;
  }
  struct Mark {
    std::size_t edited = 0, inserted = 0, removed = 0;
    int slots = 0;
  };
  /// The mark of the last commit, while nothing has changed since.
  Mark start() const { return {0, 0, 0, values_.slot_count()}; }
  Mark mark() {
    marked_ = true;
    return {numbers_.mark(), inserted_.size(), removed_.size(), values_.slot_count()};
  }
  void roll_back(const Mark& mark) {
    numbers_.roll_back(mark.edited, [this](int slot) { return values_.data(slot); });
    for (; inserted_.size() > mark.inserted; inserted_.pop_back()) {
      if (values_.contains(inserted_.back())) values_.take_back(inserted_.back(), mark.slots);
    }
    removed_.resize(mark.removed);
  }

 private:
  Values values_;
  Journal<double> numbers_;      // by slot, of variables that changed
  std::vector<unsigned> saved_;  // by slot: epoch in which they were last saved
  bool marked_ = false;          // since the last commit
  std::vector<Key> inserted_, removed_;
};

}  // namespace hybrid
