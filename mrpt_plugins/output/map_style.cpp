// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/map_style.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "libhybrid/core/quantile.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/drawing/axes.h"

namespace hybrid {
namespace {

/// On the ground; of the height of another.
Extent extent_of(const GridMap& grid, const Extent& height) {
  Extent out = height;
  out.low.head<2>() = grid.corner.array();
  out.high.head<2>() =
      grid.corner.array() + grid.resolution * Eigen::Array2d(grid.width, grid.height);
  return out;
}

}  // namespace

std::vector<Eigen::Vector3d> drawn_points(const Trajectory& all, const PathCurves& curves,
                                          const std::vector<std::size_t>& keyframes,
                                          std::size_t robot) {
  std::vector<Eigen::Vector3d> out;
  const auto add = [&](const std::vector<std::vector<Eigen::Vector3d>>& lists, std::size_t i) {
    if (i < lists.size()) out.insert(out.end(), lists[i].begin(), lists[i].end());
  };
  for (const std::size_t k : keyframes) {
    if (!out.empty()) add(curves.to, k);
    out.push_back(point_of(all[k].pose));
  }
  if (!out.empty()) add(curves.after, robot);
  return out;
}

std::vector<std::size_t> keyframes_of(const Trajectory& path) {
  std::vector<std::size_t> out(path.size());
  std::iota(out.begin(), out.end(), std::size_t{0});
  return out;
}

std::vector<DrawnPath> drawn_paths(const MapResult& result) {
  const auto points = [&](const std::vector<std::size_t>& keyframes, std::size_t robot) {
    return drawn_points(result.trajectory, result.curves, keyframes, robot);
  };
  if (result.robots.empty()) {
    return {{"estimated", points(keyframes_of(result.trajectory), 0), map_style::kEstimate}};
  }
  // Other than landmarks without class and dead reckoning.
  const std::array<Color, 6> colors = {palette::kEstimate, series_color(0), series_color(2),
                                       series_color(3),    series_color(4), series_color(5)};
  std::vector<DrawnPath> out;
  for (std::size_t i = 0; i < result.robots.size(); ++i) {
    const RobotPath& robot = result.robots[i];
    // A robot that comes again keeps its colour.
    const auto first = std::find_if(result.robots.begin(), result.robots.end(),
                                    [&](const RobotPath& r) { return r.name == robot.name; });
    Stroke stroke = map_style::kEstimate;
    stroke.color = colors[static_cast<std::size_t>(first - result.robots.begin()) % colors.size()];
    if (!robot.keyframes.empty()) {
      out.push_back({robot.name, points(robot.keyframes, i), stroke});
    }
  }
  return out;
}

std::string whose(const MapResult& result) {
  if (result.robots.empty()) return "the robot";
  std::set<std::string> robots, sessions;  // a robot may be in several sessions
  for (const RobotPath& robot : result.robots) {
    (robot.is_session ? sessions : robots).insert(robot.name);
  }
  const auto count = [](std::size_t n, const char* what) {
    return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
  };
  if (sessions.empty()) return count(robots.size(), "robot");
  if (robots.empty()) return count(sessions.size(), "session");
  return count(robots.size(), "robot") + " and " + count(sessions.size(), "session");
}

bool lists_landmarks(const MapResult& result) {
  return !result.landmarks.empty() || !result.grid;
}

std::string contents_of(const MapResult& result) {
  const std::string poses = fmt::format("{} poses of {}", result.trajectory.size(), whose(result));
  if (!lists_landmarks(result)) return poses;
  return fmt::format("{}, {} landmarks", poses, result.landmarks.size());
}

std::vector<Trajectory> true_paths(const GroundTruth& truth) {
  std::vector<Trajectory> out = {truth.path};
  out.insert(out.end(), truth.others.begin(), truth.others.end());
  out.erase(std::remove_if(out.begin(), out.end(), [](const Trajectory& t) { return t.empty(); }),
            out.end());
  return out;
}

Color landmark_color(const LandmarkEstimate& l) {
  return l.class_index ? series_color(static_cast<std::size_t>(*l.class_index))
                       : palette::kUnclassed;
}

double class_probability(const LandmarkEstimate& l) {
  if (!l.class_index || l.class_probabilities.empty()) return 1;
  return l.class_probabilities.at(static_cast<std::size_t>(*l.class_index));
}

Color landmark_fill(const LandmarkEstimate& l) {
  constexpr double kFaintest = 0.15;  // least opacity that differs from white
  const double opacity = std::clamp(class_probability(l), kFaintest, 1.0);
  const auto mixed = [opacity](std::uint8_t part) {
    return static_cast<std::uint8_t>(std::lround(255 + opacity * (part - 255.0)));
  };
  const Color color = landmark_color(l);
  return {mixed(color.red), mixed(color.green), mixed(color.blue)};
}

Marker landmark_marker(const LandmarkEstimate& l) {
  return l.class_index ? class_marker(static_cast<std::size_t>(*l.class_index)) : Marker::kCircle;
}

void Extent::add(const Eigen::Vector3d& point) {
  if (!point.allFinite()) return;
  low = low.min(point.array());
  high = high.max(point.array());
}

void Extent::add(const std::vector<Eigen::Vector3d>& points) {
  for (const Eigen::Vector3d& point : points) add(point);
}

void Extent::add(const Trajectory& path) {
  for (const TimedPose& p : path) add(Eigen::Vector3d(p.pose.x(), p.pose.y(), p.pose.z()));
}

Extent map_extent(const MapResult& result, const GroundTruth& truth) {
  Extent extent;
  for (const DrawnPath& path : drawn_paths(result)) extent.add(path.points);
  for (const Trajectory& path : true_paths(truth)) extent.add(path);
  for (const LandmarkEstimate& l : result.landmarks) extent.add(l.position);
  for (const TrueLandmark& l : truth.landmarks) extent.add(l.position);
  for (const MoverEstimate& mover : result.movers) {
    for (const MoverState& state : mover.states) extent.add(state.position);
  }
  if (extent.empty() && result.robots.empty()) extent.add(result.dead_reckoning);
  if (extent.empty()) extent.add(Eigen::Vector3d::Zero());
  if (result.grid) {
    const double room = 0.5 * (extent.high - extent.low).maxCoeff();
    const Extent seen = extent_of(*result.grid, extent);
    extent.low = extent.low.min(seen.low.max(extent.low - room));
    extent.high = extent.high.max(seen.high.min(extent.high + room));
  }
  if ((extent.high - extent.low).head<2>().maxCoeff() < 0.5) {
    extent.low.head<2>() -= 0.25;
    extent.high.head<2>() += 0.25;
  }
  return extent;
}

MapFrame map_frame(const MapResult& result, const GroundTruth& truth) {
  const Extent extent = map_extent(result, truth);
  const double size = (extent.high - extent.low).head<2>().maxCoeff();
  return {extent, ellipse_magnification(result.landmarks, size)};
}

bool is_hidden(const Trajectory& dead_reckoning, const Trajectory& estimate, const Extent& extent) {
  constexpr double kLineWidth = 0.002;  // share of the size of the picture
  if (dead_reckoning.size() != estimate.size()) return false;
  const double width = kLineWidth * (extent.high - extent.low).head<2>().maxCoeff();
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    if (dead_reckoning[i].pose.distanceTo(estimate[i].pose) > width) return false;
  }
  return true;
}

double ellipse_magnification(const std::vector<LandmarkEstimate>& landmarks, double size) {
  std::vector<double> radii;
  for (const LandmarkEstimate& l : landmarks) {
    const double variance = l.covariance.trace() / (l.is_3d ? 3 : 2);
    if (std::isfinite(variance) && variance > 0) {
      radii.push_back(map_style::kSigmas * std::sqrt(variance));
    }
  }
  if (radii.empty()) return 1;
  const double usual = median(std::move(radii));
  constexpr double kSmallest = 0.008;  // share of the size of the scene
  constexpr double kEnlarged = 0.03;   // share of it at which an ellipse is larger than its marker
  return usual >= kSmallest * size ? 1 : std::max(1.0, nice_below(kEnlarged * size / usual));
}

std::string ellipse_note(double magnification) {
  if (magnification <= 1) {
    return fmt::format("Ellipses: {:g} standard deviations.", map_style::kSigmas);
  }
  return fmt::format("Ellipses: {:g} standard deviations, enlarged {:g} times to be seen.",
                     map_style::kSigmas, magnification);
}

}  // namespace hybrid
