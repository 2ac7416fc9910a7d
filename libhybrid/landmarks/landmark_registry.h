// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/core/journaled_map.h"
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
  const Landmark* find(std::int64_t id) const { return landmarks_.find(id); }

  /// Throws Error if the id is taken.
  void add(const Landmark& landmark) {
    if (find(landmark.id) != nullptr) {
      throw Error("landmark " + std::to_string(landmark.id) + " was added twice to the map");
    }
    landmarks_.set(landmark.id, landmark);
  }

  /// Counts one more sighting; throws Error for an unknown id.
  void sighted(std::int64_t id) {
    if (find(id) == nullptr) {
      throw Error("landmark " + std::to_string(id) + " was sighted but is not in the map");
    }
    count(id, 1);
  }

  /// The reverse of sighted().
  void unsighted(std::int64_t id) {
    if (find(id) != nullptr) count(id, -1);
  }

  void remove(std::int64_t id) { landmarks_.erase(id); }

  std::size_t size() const { return landmarks_.entries().size(); }
  auto begin() const { return landmarks_.entries().begin(); }
  auto end() const { return landmarks_.entries().end(); }

  void commit() { landmarks_.commit(); }
  /// Changes since the last commit; those from a number on can be rolled back alone.
  std::size_t changes() const { return landmarks_.changes(); }
  void roll_back(std::size_t first = 0) { landmarks_.roll_back(first); }

 private:
  void count(std::int64_t id, int sightings) {
    Landmark landmark = *find(id);
    landmark.sightings += sightings;
    landmarks_.set(id, landmark);
  }

  JournaledMap<std::int64_t, Landmark> landmarks_;
};

}  // namespace hybrid
