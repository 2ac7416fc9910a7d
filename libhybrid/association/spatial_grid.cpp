// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/spatial_grid.h"

#include <algorithm>

namespace hybrid {

void SpatialGrid::put(int id, double x, double y) {
  if (id >= static_cast<int>(place_.size())) place_.resize(id + 1);
  const Place place{index(x), index(y), true};
  const Place& old = place_[id];
  if (old.used && old.x == place.x && old.y == place.y) return;
  remove(id);
  place_[id] = place;
  std::vector<int>& ids = cells_[name(place.x, place.y)];
  ids.insert(std::lower_bound(ids.begin(), ids.end(), id), id);
}

void SpatialGrid::remove(int id) {
  if (id >= static_cast<int>(place_.size()) || !place_[id].used) return;
  const auto it = cells_.find(name(place_[id].x, place_[id].y));
  std::vector<int>& ids = it->second;
  ids.erase(std::find(ids.begin(), ids.end(), id));
  if (ids.empty()) cells_.erase(it);
  place_[id].used = false;
}

}  // namespace hybrid
