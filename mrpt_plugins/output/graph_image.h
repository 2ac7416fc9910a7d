// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <utility>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/drawing/canvas.h"
#include "mrpt_plugins/drawing/image.h"

namespace HYBRID_API hybrid {

/// The content of a picture of a pose graph; positions in metres in the map frame.
struct GraphDrawing {
  using Points = std::vector<Eigen::Vector3d>;
  using Segments = std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>>;

  std::string title;
  std::string subtitle;
  bool is_3d = false;  ///< the picture is the plan and its subtitle says so
  Points poses;        ///< in order
  Points landmarks;
  Points truth;       ///< true positions of the poses; may be empty
  Segments odometry;  ///< measurements from one pose to the next
  Segments closures;  ///< accepted loop closures
  Segments rejected;  ///< rejected loop closures
};

/// The graph from above, same scale in x and y.
Image graph_image(const GraphDrawing& graph);

}  // namespace hybrid
