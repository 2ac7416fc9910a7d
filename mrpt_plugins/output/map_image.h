// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/output/map_style.h"

namespace HYBRID_API hybrid {

/// What a picture of a film shows beside the map as it then was.
struct FilmMoment {
  std::string clock;               ///< for the subtitle
  std::vector<std::int64_t> seen;  ///< landmarks that the newest pose sees, by id
};

/// map.png: the plan seen from above (x to the right, y up, metres): estimated path with start and
/// end, dead reckoning, ground truth where given, landmarks coloured and shaped by class with their
/// ids and covariance ellipses (3 standard deviations; enlarged by a round factor that the legend
/// states when they would be too small to see), fixes by their modes, legend and scale bar. It
/// shows `frame`, or all there is; of a film, rays of sight too.
Image map_image(const MapResult& result, const GroundTruth& truth = {}, int width = 1600,
                int height = 1200, const std::optional<MapFrame>& frame = {},
                const FilmMoment& moment = {});

}  // namespace hybrid
