// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/values.h"

#include <algorithm>
#include <cmath>

namespace hybrid {

void Values::insert(Key key, VariableType type, const double* x) {
  if (contains(key)) throw Error("variable " + to_string(key) + " exists already");
  if (type.dim <= 0) throw Error("variable " + to_string(key) + " has no dimension");
  for (int i = 0; i < type.size; ++i) {
    if (!std::isfinite(x[i])) throw Error("initial value of " + to_string(key) + " is not finite");
  }
  auto& reusable = free_[type.size];
  int slot;
  if (!reusable.empty()) {
    slot = reusable.back();
    reusable.pop_back();
  } else {
    slot = slot_count();
    entries_.push_back({key, type, static_cast<int>(data_.size())});
    data_.resize(data_.size() + type.size);
  }
  entries_[slot].key = key;
  entries_[slot].type = type;
  std::copy(x, x + type.size, data(slot));
  index_.emplace(key, slot);
}

void Values::erase(Key key) {
  const int erased = slot(key);
  free_[entries_[erased].type.size].push_back(erased);
  entries_[erased].type = {};
  index_.erase(key);
}

std::vector<Key> Values::keys() const {
  std::vector<Key> keys;
  keys.reserve(size());
  for (int s = 0; s < slot_count(); ++s) {
    if (occupied(s)) keys.push_back(entries_[s].key);
  }
  return keys;
}

int Values::slot(Key key) const {
  const int s = find(key);
  if (s < 0) throw Error("variable " + to_string(key) + " has no value");
  return s;
}

int Values::checked_slot(Key key, VariableType type) const {
  const int s = slot(key);
  if (entries_[s].type != type) {
    throw Error("variable " + to_string(key) + " is " + to_string(entries_[s].type) + ", not " +
                to_string(type));
  }
  return s;
}

}  // namespace hybrid
