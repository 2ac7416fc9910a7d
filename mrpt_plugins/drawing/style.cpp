// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/style.h"

#include <array>

namespace hybrid {

Color series_color(std::size_t i) {
  constexpr std::array<Color, 6> kColors = {{{230, 159, 0},
                                             {0, 158, 115},
                                             {204, 121, 167},
                                             {86, 180, 233},
                                             {136, 34, 85},
                                             {153, 153, 51}}};
  return kColors[i % kColors.size()];
}

Marker class_marker(std::size_t i) {
  constexpr std::array<Marker, 6> kMarkers = {Marker::kCircle,   Marker::kSquare,
                                              Marker::kTriangle, Marker::kDiamond,
                                              Marker::kPentagon, Marker::kStar};
  return kMarkers[(i + i / kMarkers.size()) % kMarkers.size()];
}

}  // namespace hybrid
