// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>
#include <mrpt/opengl/CFBORender.h>

#include <algorithm>
#include <stdexcept>

#include "mrpt_plugins/drawing/canvas.h"
#include "mrpt_plugins/drawing/heading.h"
#include "mrpt_plugins/drawing/labels.h"
#include "mrpt_plugins/drawing/mrpt_image.h"
#include "mrpt_plugins/output/detail/legend.h"
#include "mrpt_plugins/output/map_image.h"
#include "mrpt_plugins/output/scene.h"
#include "mrpt_plugins/output/scene_layout.h"
#include HYBRID_MRPT_SCENE(CCamera)
#include HYBRID_MRPT_SCENE(CText)

namespace hybrid {
namespace {

constexpr double kPanel = 310;
constexpr double kTop = 90;
constexpr double kMargin = 20;
constexpr Stroke kBeads{palette::kTruth, 8, LineStyle::kDotted};

/// The message of an MRPT exception in one line, without its call stack.
std::string reason(const std::string& what) {
  const std::string mark = "Message:";
  const std::size_t at = what.find(mark);
  const std::size_t from =
      at == std::string::npos ? 0 : what.find_first_not_of(' ', at + mark.size());
  std::string line = what.substr(from, what.find("\n\n", from) - from);
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

/// The scene without texts; the canvas draws these so that they do not overlap.
Image render_scene(const MapResult& result, const GroundTruth& truth, const SceneView& view,
                   int width, int height, int device) {
  const auto scene = make_scene(result, truth);
  auto viewport = scene->getViewport();
  for (const auto& object : *viewport) {
    if (std::dynamic_pointer_cast<mrpt_scene::CText>(object)) object->setVisibility(false);
  }
  const auto distance = static_cast<float>(view.distance);
  viewport->setViewportClipDistances(0.02f * distance, 20 * distance);
  mrpt::opengl::CFBORender::Parameters parameters(width, height);
  parameters.deviceIndexToUse = device;
  mrpt::opengl::CFBORender renderer(parameters);
  mrpt_scene::CCamera camera;
  camera.setPointingAt(view.target.x(), view.target.y(), view.target.z());
  camera.setZoomDistance(distance);
  camera.setAzimuthDegrees(static_cast<float>(view.azimuth_deg));
  camera.setElevationDegrees(static_cast<float>(view.elevation_deg));
  camera.setProjectiveFOVdeg(static_cast<float>(SceneView::kFieldOfViewDeg));
  set_camera(renderer, *scene, camera);
  mrpt::img::CImage picture(width, height, mrpt::img::CH_RGB);
  renderer.render_RGB(*scene, picture);
  return image_of(picture);
}

/// Draws texts over the rendered picture: ids, names of the axes, start and end.
void draw_labels(Canvas& canvas, const MapResult& result, const SceneLayout& layout,
                 const Box& box) {
  const auto seen_at = [&](const Eigen::Vector3d& p) {
    return Pixel(Pixel(box.left, box.top) + layout.view.project(p, box.width(), box.height()));
  };
  LabelPlacer labels(box);
  std::vector<std::vector<Pixel>> paths;
  for (const DrawnPath& robot : drawn_paths(result)) {
    std::vector<Pixel>& path = paths.emplace_back();
    for (const TimedPose& p : robot.poses) {
      path.push_back(seen_at({p.pose.x(), p.pose.y(), p.pose.z()}));
    }
    labels.avoid(path);
  }
  const double radius = 9;
  TextStyle axis;
  axis.size = 13;
  axis.bold = true;
  axis.halo = true;
  axis.horizontal = Align::kCenter;
  const char* names[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    const Pixel tip = seen_at(1.25 * layout.axis_length * Eigen::Vector3d::Unit(i));
    if (!box.contains(tip)) continue;
    canvas.text(tip, names[i], axis);
    labels.block(tip, 8);
  }
  for (const std::vector<Pixel>& path : paths) {
    if (path.empty()) continue;
    canvas.marker(path.front(), Marker::kTriangle, 10, palette::kWhite);
    canvas.marker(path.back(), Marker::kSquare, 8, palette::kBlack);
    labels.block(path.front(), 11);
    labels.block(path.back(), 9);
  }
  for (const LandmarkEstimate& l : result.landmarks) labels.block(seen_at(l.position), radius);
  TextStyle style;
  style.size = 10.5;
  style.halo = true;
  for (const LandmarkEstimate& l : result.landmarks) {
    labels.place(canvas, seen_at(l.position), radius, std::to_string(l.id), style);
  }
}

}  // namespace

Map3dImage map_3d_image(const MapResult& result, const GroundTruth& truth,
                        const Map3dOptions& options) {
  const Box box{kMargin, kTop, options.width - kPanel - 2 * kMargin, options.height - kMargin};
  const SceneLayout layout = scene_layout(result, truth, box.width() / box.height());
  Canvas canvas(options.width, options.height);
  try {
    canvas.paste(
        render_scene(result, truth, layout.view, static_cast<int>(box.width() * Canvas::kScale),
                     static_cast<int>(box.height() * Canvas::kScale), options.device),
        {box.left, box.top});
  } catch (const std::exception& e) {
    return {map_image(result, truth, options.width, options.height),
            fmt::format("map_3d.png is a plan, EGL device {} cannot render here: {}",
                        options.device, reason(e.what()))};
  }
  draw_labels(canvas, result, layout, box);
  draw_heading(canvas, {40, 36}, options.width - 2 * 40,
               result.title.empty() ? "Map in 3-D" : "Map of " + result.title + " in 3-D",
               fmt::format("{}; the squares on the ground are {:g} m wide", contents_of(result),
                           layout.grid_step));
  Legend legend(canvas, {options.width - kPanel - kMargin + 10, kTop + 14}, kPanel - 10);
  map_legend(legend, result, truth, kBeads, layout.frame.extent);
  if (!result.landmarks.empty()) {
    legend.ellipse("uncertainty", palette::kMuted);
    legend.note(ellipse_note("Ellipsoids", layout.frame.magnification));
    if (result.is_3d) legend.note("Thin lines drop from the landmarks to the ground.");
  }
  return {canvas.image(), ""};
}

}  // namespace hybrid
