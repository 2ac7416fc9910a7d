// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/drawing/style.h"

namespace HYBRID_API hybrid {

/// Colour of a mode of a switching system, the same in every picture.
Color mode_color(std::size_t mode);

/// One row of coloured bars: a mode for every instant, -1 where unknown.
struct ModeStrip {
  std::string label;
  std::vector<int> modes;
};

/// Modes over time, above a curve of the measurements.
struct ModeTimeline {
  std::string title, subtitle;
  std::string x_label, y_label;
  std::vector<std::string> mode_names;
  std::vector<double> x;          ///< one per sample
  std::vector<ModeStrip> strips;  ///< from the top
  std::vector<double> curve;      ///< drawn in the colours of the last strip
  bool points = false;            ///< draw the curve as separate points
  std::vector<int> folds;         ///< vertical lines where the fold changes; may be empty
};

/// Draws it, 1600 x 900. Throws std::invalid_argument where lists differ in length.
Image mode_timeline_image(const ModeTimeline& timeline);

/// A path in 2-D, each step in the colour of its mode.
struct ModePath {
  std::string title, subtitle;
  std::string x_label = "x (m)", y_label = "y (m)";
  std::vector<std::string> mode_names;
  std::vector<Eigen::Vector2d> points;
  std::vector<int> modes;              ///< one per point, -1 unknown
  std::vector<Eigen::Vector2d> truth;  ///< drawn below, in grey; may be empty
  bool markers = false;                ///< points instead of a line
};

/// Draws it, both axes to the same scale.
Image mode_path_image(const ModePath& path);

}  // namespace hybrid
