// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/map_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "mrpt_plugins/drawing/axes.h"
#include "mrpt_plugins/drawing/heading.h"
#include "mrpt_plugins/drawing/labels.h"
#include "mrpt_plugins/output/detail/fix_layer.h"
#include "mrpt_plugins/output/detail/legend.h"

namespace hybrid {
namespace {

constexpr double kLegendWidth = 310;  // width of the legend's column

std::vector<Pixel> to_pixels(const Axes& axes, const Trajectory& path) {
  std::vector<Pixel> out;
  for (const TimedPose& p : path) out.push_back(axes.pixel(p.pose.x(), p.pose.y()));
  return out;
}

std::vector<Pixel> to_pixels(const Axes& axes, const std::vector<Eigen::Vector3d>& points) {
  std::vector<Pixel> out;
  for (const Eigen::Vector3d& p : points) out.push_back(axes.pixel(p.x(), p.y()));
  return out;
}

/// What laser scans saw, at the resolution of the sheet, as far as a box shows it.
class GridSheet {
 public:
  GridSheet(const Axes& axes, const Box& box, const GridMap& grid)
      : grid_(grid),
        image_{static_cast<int>(Canvas::kScale * box.width()),
               static_cast<int>(Canvas::kScale * box.height()),
               {}} {
    constexpr std::uint8_t kWhite = 255;
    image_.rgb.assign(kBytes * size(image_.width) * size(image_.height), kWhite);
    const Pixel corner = axes.pixel(grid.corner.x(), grid.corner.y());
    scale_ = Canvas::kScale * axes.pixels_per_unit() * grid.resolution;
    left_ = Canvas::kScale * (corner.x() - box.left);
    bottom_ = Canvas::kScale * (corner.y() - box.top);
  }

  /// Paints all cells of a kind, each at least a pixel large.
  void paint(GridMap::Cell kind, const Color& color) {
    for (int y = 0; y < grid_.height; ++y) {
      const int top = clamped(bottom_ - (y + 1) * scale_, image_.height);
      const int below = clamped(bottom_ - y * scale_ + 1, image_.height);
      for (int x = 0; x < grid_.width; ++x) {
        if (grid_.at(x, y) != kind) continue;
        const int from = clamped(left_ + x * scale_, image_.width);
        const int to = clamped(left_ + (x + 1) * scale_ + 1, image_.width);
        for (int row = top; row < below; ++row) paint_row(row, from, to, color);
      }
    }
  }

  const Image& image() const { return image_; }

 private:
  static constexpr std::size_t kBytes = 3;  // of a pixel

  static std::size_t size(int count) { return static_cast<std::size_t>(count); }
  static int clamped(double at, int end) {
    return static_cast<int>(std::clamp(std::floor(at), 0.0, static_cast<double>(end)));
  }
  void paint_row(int row, int from, int to, const Color& color) {
    for (int column = from; column < to; ++column) {
      const std::size_t at = kBytes * (size(row) * size(image_.width) + size(column));
      image_.rgb[at] = color.red;
      image_.rgb[at + 1] = color.green;
      image_.rgb[at + 2] = color.blue;
    }
  }

  const GridMap& grid_;
  Image image_;
  double scale_ = 1, left_ = 0, bottom_ = 0;  // of a cell, and where the grid begins [pixels]
};

void draw_grid(Canvas& canvas, const Axes& axes, const Box& box, const GridMap& grid) {
  GridSheet sheet(axes, box, grid);
  sheet.paint(GridMap::kFree, map_style::kFreeFloor);
  sheet.paint(GridMap::kOccupied, map_style::kWall);
  canvas.paste(sheet.image(), {box.left, box.top});
}

/// The id of a landmark and, where it stands for several things, their number.
std::string label_of(const LandmarkEstimate& l) {
  return l.size.things > 1 ? fmt::format("{} \u00d7{}", l.id, l.size.things) : std::to_string(l.id);
}

std::vector<Pixel> ellipse(const Axes& axes, const LandmarkEstimate& landmark,
                           const Eigen::Matrix2d& covariance, double sigmas) {
  std::vector<Pixel> outline;
  for (const auto& p : covariance_ellipse(landmark.position.head<2>(), covariance, sigmas)) {
    outline.push_back(axes.pixel(p.x(), p.y()));
  }
  return outline;
}

void draw_ellipses(Canvas& canvas, const Axes& axes, const MapResult& result, double factor) {
  for (const LandmarkEstimate& l : result.landmarks) {
    const Eigen::Matrix2d covariance = l.covariance.topLeftCorner<2, 2>();
    if (!covariance.allFinite() || !(covariance.trace() > 0)) continue;
    const std::vector<Pixel> outline = ellipse(axes, l, covariance, map_style::kSigmas * factor);
    canvas.fill(outline, landmark_color(l), 0.25);
    canvas.polyline(outline, {landmark_color(l), 1.25});
  }
}

/// How far from landmarks things are that were not told apart from them: a standard deviation.
void draw_extents(Canvas& canvas, const Axes& axes, const MapResult& result) {
  for (const LandmarkEstimate& l : result.landmarks) {
    if (!(l.size.extent > 0)) continue;
    const Eigen::Matrix2d spread = l.size.extent * l.size.extent * Eigen::Matrix2d::Identity();
    canvas.polyline(ellipse(axes, l, spread, 1), {landmark_color(l), 1, LineStyle::kDotted});
  }
}

void extent_legend(Legend& legend, const MapResult& result) {
  const auto& all = result.landmarks;
  if (std::any_of(all.begin(), all.end(), [](const auto& l) { return l.size.extent > 0; })) {
    legend.line("extent", {palette::kMuted, 1, LineStyle::kDotted});
  }
  const auto several =
      std::find_if(all.begin(), all.end(), [](const auto& l) { return l.size.things > 1; });
  if (several == all.end()) return;
  legend.note(fmt::format("{}: {} things in one place.", label_of(*several), several->size.things));
}

/// The true path, split where the receiver had no position.
std::vector<Trajectory> pieces(const Trajectory& path) {
  constexpr double kGap = 10;  // times the median interval
  std::vector<double> steps;
  for (std::size_t i = 1; i < path.size(); ++i) steps.push_back(path[i].time - path[i - 1].time);
  if (steps.empty()) return {path};
  std::vector<double> sorted = steps;
  std::sort(sorted.begin(), sorted.end());
  const double usual = sorted[sorted.size() / 2];
  std::vector<Trajectory> out(1);
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i > 0 && steps[i - 1] > kGap * usual) out.emplace_back();
    out.back().push_back(path[i]);
  }
  return out;
}

/// The motions of modes other than the first.
void draw_modes(Canvas& canvas, const Axes& axes, const MapResult& result) {
  if (result.motion_modes.empty()) return;
  std::vector<RobotPath> robots = result.robots;
  if (robots.empty()) robots.push_back({"", keyframes_of(result.trajectory)});
  for (const RobotPath& robot : robots) {
    for (std::size_t i = 1; i < robot.keyframes.size(); ++i) {
      const std::vector<std::size_t> ends{robot.keyframes[i - 1], robot.keyframes[i]};
      const int mode = result.motion_modes[ends[1]];
      if (mode <= 0) continue;
      const std::vector<Pixel> path =
          to_pixels(axes, drawn_points(result.trajectory, {result.curves.to, {}}, ends, 0));
      for (std::size_t j = 1; j < path.size(); ++j) {
        canvas.line(path[j - 1], path[j], map_style::mode_stroke(mode));
      }
    }
  }
}

void draw_paths(Canvas& canvas, const Axes& axes, const MapResult& result, const GroundTruth& truth,
                LabelPlacer& labels) {
  for (const Trajectory& known : true_paths(truth)) {
    for (const Trajectory& piece : pieces(known)) {
      canvas.polyline(to_pixels(axes, piece), map_style::kTruth);
    }
  }
  if (result.robots.empty()) {
    const std::vector<Pixel> reckoned =
        to_pixels(axes, drawn_points(result.dead_reckoning, result.reckoned_curves,
                                     keyframes_of(result.dead_reckoning), 0));
    canvas.polyline(reckoned, map_style::kDeadReckoning);  // is_hidden() tells the legend
    labels.avoid(reckoned);
  }
  const std::vector<DrawnPath> robots = drawn_paths(result);
  for (const DrawnPath& robot : robots) {
    const std::vector<Pixel> path = to_pixels(axes, robot.points);
    canvas.polyline(path, robot.stroke);
    labels.avoid(path);
  }
  draw_modes(canvas, axes, result);
  for (const DrawnPath& robot : robots) {
    if (robot.points.empty()) continue;
    const std::vector<Pixel> path = to_pixels(axes, robot.points);
    canvas.marker(path.front(), Marker::kTriangle, 10, palette::kWhite);
    canvas.marker(path.back(), Marker::kSquare, 8, palette::kBlack);
    labels.block(path.front(), 11);
    labels.block(path.back(), 9);
  }
}

const Stroke& stroke_of(const ScanClosureEstimate& closure) {
  if (closure.decision.accepted()) return map_style::kAcceptedClosure;
  return closure.decision.status == ClosureStatus::kRejected ? map_style::kRejectedClosure
                                                             : map_style::kUndecidedClosure;
}

/// Closures by scans between the poses of their keyframes, those accepted on top.
void draw_closures(Canvas& canvas, const Axes& axes, const MapResult& result) {
  for (const bool accepted : {false, true}) {
    for (const ScanClosureEstimate& closure : result.scan_closures) {
      if (closure.decision.accepted() != accepted) continue;
      const auto& from = result.trajectory[closure.from].pose;
      const auto& to = result.trajectory[closure.to].pose;
      canvas.line(axes.pixel(from.x(), from.y()), axes.pixel(to.x(), to.y()), stroke_of(closure));
    }
  }
}

void closure_legend(Legend& legend, const MapResult& result) {
  std::map<std::string, std::pair<std::size_t, Stroke>> counts;
  for (const ScanClosureEstimate& closure : result.scan_closures) {
    const std::string status = to_string(closure.decision.status);
    ++counts.try_emplace(status, 0, stroke_of(closure)).first->second.first;
  }
  for (const auto& [status, entry] : counts) {
    legend.line(fmt::format("closure {} ({})", status, entry.first), entry.second);
  }
}

/// The trajectories of things that move, with a dot where each was seen last.
void draw_movers(Canvas& canvas, const Axes& axes, const MapResult& result, LabelPlacer& labels) {
  for (const MoverEstimate& mover : result.movers) {
    std::vector<Pixel> path;
    for (const MoverState& s : mover.states) {
      path.push_back(axes.pixel(s.position.x(), s.position.y()));
    }
    if (path.empty()) continue;
    canvas.polyline(path, map_style::kMover);
    canvas.marker(path.back(), Marker::kCircle, 4, map_style::kMover.color);
    labels.avoid(path);
  }
}

/// From the newest pose to the landmarks that it sees.
void draw_rays(Canvas& canvas, const Axes& axes, const MapResult& result,
               const std::vector<std::int64_t>& seen) {
  if (result.trajectory.empty()) return;
  const auto& here = result.trajectory.back().pose;
  for (const LandmarkEstimate& l : result.landmarks) {
    if (std::find(seen.begin(), seen.end(), l.id) == seen.end()) continue;
    canvas.line(axes.pixel(here.x(), here.y()), axes.pixel(l.position.x(), l.position.y()),
                map_style::kSight);
  }
}

/// Draws markers, then ids where there is room; returns how many ids were drawn.
std::size_t draw_landmarks(Canvas& canvas, const Axes& axes, const MapResult& result,
                           const GroundTruth& truth, LabelPlacer& labels) {
  const double radius = result.landmarks.size() > 400 ? 4 : 7;
  for (const TrueLandmark& l : truth.landmarks) {
    const Pixel p = axes.pixel(l.position.x(), l.position.y());
    canvas.marker(p, Marker::kPlus, 2 * radius, map_style::kTrueLandmark);
    labels.block(p, radius);
  }
  for (const LandmarkEstimate& l : result.landmarks) {
    const Pixel p = axes.pixel(l.position.x(), l.position.y());
    canvas.marker(p, landmark_marker(l), radius, landmark_fill(l));
    labels.block(p, radius);
  }
  TextStyle style;
  style.size = 10.5;
  style.halo = true;
  std::size_t drawn = 0;
  for (const LandmarkEstimate& l : result.landmarks) {
    const Pixel p = axes.pixel(l.position.x(), l.position.y());
    if (labels.place(canvas, p, radius, label_of(l), style)) ++drawn;
  }
  return drawn;
}

}  // namespace

Image map_image(const MapResult& result, const GroundTruth& truth, int width, int height,
                const std::optional<MapFrame>& shown, const FilmMoment& moment) {
  Canvas canvas(width, height);
  Box box{110, 100, width - kLegendWidth - 55, height - 85.0};
  const MapFrame frame = shown ? *shown : map_frame(result, truth);
  const Extent& extent = frame.extent;
  const double rim = 0.05 * (extent.high - extent.low).head<2>().maxCoeff();
  Axis x{"x (m)", Scale::kLinear, {{extent.low.x() - rim, extent.high.x() + rim}}};
  Axis y{"y (m)", Scale::kLinear, {{extent.low.y() - rim, extent.high.y() + rim}}};
  Axes::equalize(box, x, y);
  box.left = std::max(box.left, Axes(box, x, y).left_room());
  Axes::equalize(box, x, y);
  const Axes axes(box, x, y);
  draw_heading(
      canvas, {box.left, 36}, width - box.left - 25,
      result.title.empty() ? "Map" : "Map of " + result.title,
      fmt::format("{}: {}{}", result.is_3d ? "3-D map seen from above (z left out)" : "Plan",
                  moment.clock, contents_of(result)));
  if (result.grid) draw_grid(canvas, axes, box, *result.grid);
  axes.draw(canvas);

  LabelPlacer labels(box);
  canvas.clip(box);
  draw_closures(canvas, axes, result);
  draw_ellipses(canvas, axes, result, frame.magnification);
  draw_extents(canvas, axes, result);
  draw_fixes(canvas, axes, box, result);
  draw_rays(canvas, axes, result, moment.seen);
  draw_paths(canvas, axes, result, truth, labels);
  draw_movers(canvas, axes, result, labels);
  const std::size_t ids = draw_landmarks(canvas, axes, result, truth, labels);
  canvas.unclip();

  Legend legend(canvas, {box.right + 30, box.top + 14}, kLegendWidth);
  map_legend(legend, result, truth, extent);
  closure_legend(legend, result);
  if (!moment.seen.empty()) legend.line("seen now", map_style::kSight);
  if (!result.landmarks.empty()) {
    legend.ellipse("uncertainty", palette::kMuted);
    legend.note(ellipse_note(frame.magnification));
    extent_legend(legend, result);
  }
  if (ids < result.landmarks.size()) {
    legend.note(
        fmt::format("{} of {} ids shown, the others had no room.", ids, result.landmarks.size()));
  }
  fix_legend(legend, axes, box, result);
  scale_bar(canvas, {box.right + 34, box.bottom - 40}, axes.pixels_per_unit(), kLegendWidth - 40);
  return canvas.image();
}

}  // namespace hybrid
