// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <unordered_map>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/core/key.h"
#include "libhybrid/core/variable.h"

namespace HYBRID_API hybrid {

/// The values of continuous variables, C in the paper: one flat array of doubles and an index by
/// key. A variable has a slot, a small integer that stays the same until the variable is erased.
class Values {
 public:
  /// Throws Error if the key is there already or the value is not finite. A rotation that is not of
  /// unit norm is scaled to it; one of norm zero is refused.
  template <class T>
  void insert(Key key, const T& value) {
    double x[Variable<T>::kSize];
    Variable<T>::store(value, x);
    insert(key, Variable<T>::type(), x);
  }
  void insert(Key key, VariableType type, const double* x);
  /// A vector whose length is known at run time only.
  void insert(Key key, const Eigen::VectorXd& value) {
    insert(key, vector_type(static_cast<int>(value.size())), value.data());
  }

  /// Replaces the value of a variable that is there, of the same type.
  template <class T>
  void update(Key key, const T& value) {
    Variable<T>::store(value, data(checked_slot(key, Variable<T>::type())));
  }

  template <class T>
  T at(Key key) const {
    return Variable<T>::load(data(checked_slot(key, Variable<T>::type())));
  }

  /// A vector of any length; throws Error for a variable that is no vector.
  Eigen::VectorXd vector(Key key) const;

  bool contains(Key key) const { return index_.count(key) != 0; }
  void erase(Key key);
  /// Undoes the insertion of a variable; `slots` is slot_count() before it. Several insertions are
  /// undone in reverse order.
  void take_back(Key key, int slots);
  std::size_t size() const { return index_.size(); }
  bool empty() const { return index_.empty(); }

  /// Keys in order of slot, which is the order of insertion while nothing has been erased.
  std::vector<Key> keys() const;

  /// Slots below this bound exist or have been erased.
  int slot_count() const { return static_cast<int>(entries_.size()); }
  /// Throws Error for an unknown key.
  int slot(Key key) const;
  /// -1 for an unknown key.
  int find(Key key) const {
    const auto it = index_.find(key);
    return it == index_.end() ? -1 : it->second;
  }
  bool occupied(int slot) const { return entries_[slot].type.dim != 0; }
  Key key(int slot) const { return entries_[slot].key; }
  VariableType type(int slot) const { return entries_[slot].type; }
  VariableType type(Key key) const { return type(slot(key)); }
  const double* data(int slot) const { return data_.data() + entries_[slot].offset; }
  double* data(int slot) { return data_.data() + entries_[slot].offset; }
  const double* data(Key key) const { return data(slot(key)); }
  /// Approximate memory in use.
  std::size_t bytes() const {
    return data_.capacity() * sizeof(double) + entries_.capacity() * sizeof(Entry) +
           index_.size() * (sizeof(Key) + 4 * sizeof(void*));
  }

 private:
  struct Entry {
    Key key;
    VariableType type;
    int offset = 0;
  };

  int checked_slot(Key key, VariableType type) const;

  std::unordered_map<Key, int> index_;
  std::vector<Entry> entries_;
  std::vector<double> data_;
  std::unordered_map<int, std::vector<int>> free_;  // erased slots by storage size
};

}  // namespace hybrid
