// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "libhybrid/core/error.h"
#include "libhybrid/core/key.h"

namespace hybrid {

/// A landmark of the map: the names of its variables and how often it was seen.
struct Landmark {
  std::int64_t id = 0;
  Key position;                          ///< a vector of 2 or 3, metres in the map frame
  std::optional<DiscreteKey> class_key;  ///< its class, for landmarks that have one
  int sightings = 0;
};

/// All landmarks by id, in order of id.
class LandmarkBook {
 public:
  /// Null if there is no landmark of that id.
  const Landmark* find(std::int64_t id) const {
    const auto it = landmarks_.find(id);
    return it == landmarks_.end() ? nullptr : &it->second;
  }

  /// Throws Error if the id is taken.
  void add(const Landmark& landmark) {
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
    ++it->second.sightings;
  }

  /// The reverse of sighted().
  void unsighted(std::int64_t id) {
    const auto it = landmarks_.find(id);
    if (it != landmarks_.end()) --it->second.sightings;
  }

  void remove(std::int64_t id) { landmarks_.erase(id); }

  std::size_t size() const { return landmarks_.size(); }
  auto begin() const { return landmarks_.begin(); }
  auto end() const { return landmarks_.end(); }

 private:
  std::map<std::int64_t, Landmark> landmarks_;
};

}  // namespace hybrid
