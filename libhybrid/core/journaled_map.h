// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A map whose changes since the last `commit` can be taken back, at the cost of what was changed.
template <class Key, class Value>
class JournaledMap {
 public:
  const std::map<Key, Value>& entries() const { return entries_; }

  /// Null if there is no such entry.
  const Value* find(const Key& key) const {
    const auto it = entries_.find(key);
    return it == entries_.end() ? nullptr : &it->second;
  }
  void set(const Key& key, Value value) {
    note(key);
    entries_.insert_or_assign(key, std::move(value));
  }
  void erase(const Key& key) {
    note(key);
    entries_.erase(key);
  }

  void commit() { before_.clear(); }
  /// Changes since the last commit; those from a number on can be taken back alone.
  std::size_t changes() const { return before_.size(); }
  void roll_back(std::size_t first = 0) {
    for (; before_.size() > first; before_.pop_back()) {
      auto& [key, value] = before_.back();
      if (value) {
        entries_.insert_or_assign(key, std::move(*value));
      } else {
        entries_.erase(key);
      }
    }
  }

 private:
  void note(const Key& key) {
    const Value* value = find(key);
    before_.emplace_back(key, value == nullptr ? std::nullopt : std::make_optional(*value));
  }

  std::map<Key, Value> entries_;
  std::vector<std::pair<Key, std::optional<Value>>> before_;  // of each change, in order
};

}  // namespace hybrid
