// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/drawing/axes.h"
#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/drawing/style.h"

namespace HYBRID_API hybrid {

/// One set of points: a line, markers, or both. Values that are not finite (or not positive on a
/// logarithmic axis) interrupt the line.
struct Series {
  std::string label;  ///< text in the legend; none if empty
  std::vector<double> x, y;
  Color color = palette::kEstimate;
  LineStyle line = LineStyle::kSolid;
  double width = 2;  ///< pixels
  Marker marker = Marker::kNone;
  double marker_radius = 6;                    ///< pixels
  std::vector<double> lower = {}, upper = {};  ///< ends of error bars, one per point, or empty
  std::vector<std::string> notes = {};         ///< a text beside each point, or empty
  bool band = false;  ///< draw lower to upper as a band along the line instead of bars
};

/// A picture of one pair of axes, with the legend above the frame.
struct PlotSpec {
  std::string title;
  std::string subtitle;  ///< describes the picture
  Axis x, y;
  std::vector<Series> series;
  bool equal_aspect = false;  ///< same scale in x and y
  bool y_down = false;        ///< low y at the top, as for matrices
  int width = 1600;           ///< pixels
  int height = 1000;
};

/// Draws the plot. Throws std::invalid_argument if the lists of a series differ in length or an
/// axis range is empty or not positive on a logarithmic axis.
Image render(const PlotSpec& spec);

}  // namespace hybrid
