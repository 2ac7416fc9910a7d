// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/core/key.h"

namespace HYBRID_API hybrid {

/// A landmark of the map: the names of its variables and how often it was seen.
struct Landmark {
  std::int64_t id = 0;
  Key position;                          ///< a vector of 2 or 3, metres in the map frame
  std::optional<DiscreteKey> class_key;  ///< its class, for landmarks that have one
  int sightings = 0;
};

/// All landmarks by id, in order of id. What happened since the last `commit` can be rolled back.
class LandmarkRegistry {
 public:
  /// Null if there is no landmark of that id.
  const Landmark* find(std::int64_t id) const {
    const auto it = landmarks_.find(id);
    return it == landmarks_.end() ? nullptr : &it->second;
  }

  /// Throws Error if the id is taken.
  void add(const Landmark& landmark) {
    note(landmark.id);
    if (!landmarks_.emplace(landmark.id, landmark).second) {
      throw Error("landmark " + std::to_string(landmark.id) + " was added twice to the map");
    }
  }

  /// Counts one more sighting; throws Error for an unknown id.
  void sighted(std::int64_t id) {
    const auto it = landmarks_.find(id);
    if (it == landmarks_.end()) {
      throw Error("landmark " + std::to_string(id) + " was sighted but is not in the map");
    }
    note(id);
    ++it->second.sightings;
  }

  /// The reverse of sighted().
  void unsighted(std::int64_t id) {
    const auto it = landmarks_.find(id);
    if (it == landmarks_.end()) return;
    note(id);
    --it->second.sightings;
  }

  void remove(std::int64_t id) {
    note(id);
    landmarks_.erase(id);
  }

  std::size_t size() const { return landmarks_.size(); }
  auto begin() const { return landmarks_.begin(); }
  auto end() const { return landmarks_.end(); }

  void commit() { before_.clear(); }
  /// Changes since the last commit; those from a number on can be rolled back alone.
  std::size_t changes() const { return before_.size(); }
  void roll_back(std::size_t first = 0) {
    for (; before_.size() > first; before_.pop_back()) {
      const auto& [id, landmark] = before_.back();
      landmarks_.erase(id);
      if (landmark) landmarks_.emplace(id, *landmark);
    }
  }

 private:
  void note(std::int64_t id) {
    const Landmark* landmark = find(id);
    before_.emplace_back(id, landmark == nullptr ? std::nullopt : std::make_optional(*landmark));
  }

  std::map<std::int64_t, Landmark> landmarks_;
  std::vector<std::pair<std::int64_t, std::optional<Landmark>>> before_;  // since the last commit
};

}  // namespace hybrid
