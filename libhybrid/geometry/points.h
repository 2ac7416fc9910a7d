// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// A point cloud: positions in one frame and one unit of length.
using Points = std::vector<Eigen::Vector3d>;

/// The box along the axes about things, each at `position(thing)`; empty where there are none.
template <class Things, class Position>
auto box_of(const Things& things, const Position& position) {
  using Point = decltype(position(*things.begin()));
  Eigen::AlignedBox<double, Point::RowsAtCompileTime> box;
  for (const auto& thing : things) box.extend(position(thing));
  return box;
}

}  // namespace hybrid
