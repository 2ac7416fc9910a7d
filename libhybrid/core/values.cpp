// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/values.h"

#include <algorithm>
#include <cmath>
#include <new>

namespace hybrid {

void Values::insert(Key key, VariableType type, const double* x) {
  if (contains(key)) throw Error("variable " + to_string(key) + " exists already");
  if (type.dim <= 0) throw Error("variable " + to_string(key) + " has no dimension");
  const auto finite = [&] {
    return std::all_of(x, x + type.size, [](double v) { return std::isfinite(v); });
  };
  if (!finite()) throw Error("initial value of " + to_string(key) + " is not finite");
  std::vector<double> unit;
  if (type.kind != VariableKind::kVector) {
    unit.assign(x, x + type.size);
    normalize(type, unit.data());
    x = unit.data();
    if (!finite()) throw Error("initial value of " + to_string(key) + " is no " + to_string(type));
  }
  auto& reusable = free_[type.size];
  const bool fresh = reusable.empty();
  const int slot = fresh ? slot_count() : reusable.back();
  const std::size_t end = data_.size();
  index_.emplace(key, slot);
  try {
    if (fresh) {
      data_.resize(end + type.size);
      entries_.push_back({key, type, static_cast<int>(end)});
    }
  } catch (...) {
    data_.resize(end);
    index_.erase(key);
    throw;
  }
  if (!fresh) reusable.pop_back();
  entries_[slot].key = key;
  entries_[slot].type = type;
  std::copy(x, x + type.size, data(slot));
}

Eigen::VectorXd Values::vector(Key key) const {
  const VariableType type = this->type(key);
  return Eigen::Map<const Eigen::VectorXd>(data(checked_slot(key, vector_type(type.dim))),
                                           type.dim);
}

void Values::erase(Key key) {
  const int erased = slot(key);
  try {
    free_[entries_[erased].type.size].push_back(erased);
  } catch (const std::bad_alloc&) {  // NOLINT(bugprone-empty-catch): the slot is not used again
  }
  entries_[erased].type = {};
  index_.erase(key);
}

void Values::take_back(Key key, int slots) {
  const int last = slot(key);
  if (last < slots) return erase(key);
  data_.resize(entries_[last].offset);
  entries_.pop_back();
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
