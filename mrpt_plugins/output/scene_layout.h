// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/output/map_style.h"

namespace HYBRID_API hybrid {

/// A camera that looks at a point, z up, in perspective.
struct SceneView {
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< m
  double distance = 10;                              ///< from eye to target, m
  double azimuth_deg = -112;
  double elevation_deg = 35;
  static constexpr double kFieldOfViewDeg = 30;

  Eigen::Vector3d eye() const;
  /// Position in a picture of the given size; NaN for points behind the camera.
  Pixel project(const Eigen::Vector3d& point, double width, double height) const;
};

/// Sizes of the objects in a scene [m], and the view that shows all of it.
struct SceneLayout {
  Extent ground;  ///< flat, in whole squares of the grid
  double grid_step = 1;
  double path_radius = 0.02;
  double landmark_radius = 0.1;
  double wall_height = 0.1;  ///< of what laser scans saw
  double axis_length = 1;
  MapFrame frame;  ///< as in the plan
  SceneView view;
};

/// The view at an elevation [deg] that shows all points, in a picture `aspect` times as wide as
/// high.
SceneView view_of(const std::vector<Eigen::Vector3d>& points, double elevation_deg, double aspect);

/// The layout for a picture `aspect` times as wide as high.
SceneLayout scene_layout(const MapResult& result, const GroundTruth& truth, double aspect = 1.2);

}  // namespace hybrid
