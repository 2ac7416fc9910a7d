// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>

#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/output/map_style.h"

namespace HYBRID_API hybrid {

/// map.png: the plan seen from above (x to the right, y up, metres), with the estimated path, its
/// start and end, dead reckoning, ground truth (if given), landmarks coloured and shaped by class
/// with their ids and covariance ellipses (3 standard deviations; enlarged by a round factor, named
/// in the legend, if they would be too small to see), legend and scale bar. It shows `frame`, or
/// everything. If `clock` is given, it is the subtitle, and the picture is a frame of a film.
Image map_image(const MapResult& result, const GroundTruth& truth = {}, int width = 1600,
                int height = 1200, const std::optional<MapFrame>& frame = {},
                const std::string& clock = {});

}  // namespace hybrid
