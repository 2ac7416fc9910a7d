// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/mrpt_version.h"
#include HYBRID_MRPT_SCENE(HYBRID_MRPT_SCENE_CLASS)

namespace HYBRID_API hybrid {

using MrptScene = mrpt_scene::HYBRID_MRPT_SCENE_CLASS;

/// The map as an MRPT scene (metres): ground grid, paths as tubes, landmarks as solids coloured and
/// shaped by class with covariance ellipsoids (3 standard deviations, enlarged as in map_image) and
/// ids as text, and what laser scans saw as low walls. Only one renderer can render a scene.
MrptScene::Ptr make_scene(const MapResult& result, const GroundTruth& truth = {});

/// Writes the scene as `name` (.3Dscene) for SceneViewer3D.
void save_scene(const OutputDirectory& out, const std::string& name, const MapResult& result,
                const GroundTruth& truth = {});

struct Map3dOptions {
  int width = 1600;  ///< pixels
  int height = 1200;
  int device = 0;  ///< index of the EGL device
};

/// A 3-D view, or the plan and a warning if 3-D rendering is not possible.
struct Map3dImage {
  Image image;
  std::string warning;  ///< empty when the view is 3-D
};

/// map_3d.png, drawn off screen through EGL without a display.
Map3dImage map_3d_image(const MapResult& result, const GroundTruth& truth = {},
                        const Map3dOptions& options = {});

}  // namespace hybrid
