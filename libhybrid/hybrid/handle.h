// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <new>
#include <utility>
#include <vector>

#include "libhybrid/core/error.h"

namespace HYBRID_API hybrid {

enum class FactorKind : std::uint8_t { kContinuous, kDiscrete, kHybrid };

/// Stable name of a factor in a graph: valid from its addition to its removal, and never reused.
struct Handle {
  FactorKind kind = FactorKind::kContinuous;
  std::uint32_t index = 0;
  std::uint32_t generation = 0;  // 0 names no factor

  bool valid() const { return generation != 0; }
  friend bool operator==(Handle a, Handle b) {
    return a.kind == b.kind && a.index == b.index && a.generation == b.generation;
  }
};

/// Handles of the factors that a change has added: by kind, in the order of the change.
struct AddedHandles {
  std::vector<Handle> continuous, discrete, hybrid;

  std::size_t size() const { return continuous.size() + discrete.size() + hybrid.size(); }
  bool empty() const { return size() == 0; }
  /// All of them, e.g. to remove what a change has added.
  std::vector<Handle> all() const {
    std::vector<Handle> all = continuous;
    all.insert(all.end(), discrete.begin(), discrete.end());
    all.insert(all.end(), hybrid.begin(), hybrid.end());
    return all;
  }
};

/// Items of one kind by stable handle. Places are reused, so that memory is bounded by the largest
/// number of items alive at once.
template <class T>
class HandleList {
 public:
  explicit HandleList(FactorKind kind) : kind_(kind) {}

  Handle add(T item) {
    auto index = static_cast<std::uint32_t>(places_.size());
    if (free_.empty()) {
      places_.emplace_back();
    } else {
      index = free_.back();
      free_.pop_back();
    }
    places_[index].item = std::move(item);
    places_[index].alive = true;
    places_[index].generation = ++places_[index].issued;
    ++size_;
    return {kind_, index, places_[index].generation};
  }

  T remove(Handle handle) {
    check(handle);
    try {
      free_.push_back(handle.index);
    } catch (const std::bad_alloc&) {  // NOLINT(bugprone-empty-catch): the place stays empty
    }
    Place& place = places_[handle.index];
    place.alive = false;
    --size_;
    return std::exchange(place.item, T{});
  }

  /// Undoes the removal of an item: its handle is valid again.
  void put_back(Handle handle, T item) {
    const auto free = std::find(free_.rbegin(), free_.rend(), handle.index);
    if (free != free_.rend()) free_.erase(free.base() - 1);
    Place& place = places_[handle.index];
    place.item = std::move(item);
    place.generation = handle.generation;
    place.alive = true;
    ++size_;
  }

  bool contains(Handle handle) const {
    return handle.kind == kind_ && handle.index < places_.size() && places_[handle.index].alive &&
           places_[handle.index].generation == handle.generation;
  }
  const T& at(Handle handle) const {
    check(handle);
    return places_[handle.index].item;
  }
  std::size_t size() const { return size_; }

  /// Places 0 to capacity() - 1 may hold an item; alive(i) tells whether place i does.
  std::uint32_t capacity() const { return static_cast<std::uint32_t>(places_.size()); }
  bool alive(std::uint32_t index) const { return places_[index].alive; }
  const T& operator[](std::uint32_t index) const { return places_[index].item; }
  Handle handle(std::uint32_t index) const { return {kind_, index, places_[index].generation}; }

  template <class Function>
  void for_each(Function&& function) const {
    for (std::uint32_t i = 0; i < places_.size(); ++i) {
      if (places_[i].alive) function(handle(i), places_[i].item);
    }
  }

 private:
  struct Place {
    T item{};
    std::uint32_t generation = 0;
    std::uint32_t issued = 0;  // the highest generation so far
    bool alive = false;
  };

  void check(Handle handle) const {
    if (!contains(handle)) throw Error("a factor handle is not, or no longer, in the graph");
  }

  FactorKind kind_;
  std::vector<Place> places_;
  std::vector<std::uint32_t> free_;
  std::size_t size_ = 0;
};

}  // namespace hybrid
