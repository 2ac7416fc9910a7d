// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/places.h"

#include <unordered_set>

namespace hybrid {

Places places_of(const std::vector<int>& slots, const Values& values) {
  Places place;
  for (int slot : slots) place.append(slot, values.data(slot), values.type(slot).size);
  return place;
}

Places with_others(const Places& place, const Places& others, const Values& values) {
  Places all = place;
  std::unordered_set<int> known(place.slots.begin(), place.slots.end());
  const double* x = others.numbers.data();
  for (int slot : others.slots) {
    const int size = values.type(slot).size;
    if (known.insert(slot).second) all.append(slot, x, size);
    x += size;
  }
  return all;
}

std::vector<double> way_from(const Places& start, const Values& values) {
  std::vector<double> way;
  const double* x = start.numbers.data();
  for (int slot : start.slots) {
    const VariableType type = values.type(slot);
    way.resize(way.size() + type.dim);
    local(type, x, values.data(slot), way.data() + way.size() - type.dim);
    x += type.size;
  }
  return way;
}

}  // namespace hybrid
