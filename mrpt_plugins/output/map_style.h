// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/drawing/canvas.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/output/mode_image.h"

namespace HYBRID_API hybrid {

/// Styles of the parts of a map, the same in every picture of it.
namespace map_style {
constexpr Stroke kEstimate{palette::kEstimate, 2.5, LineStyle::kSolid};
constexpr Stroke kDeadReckoning{palette::kDeadReckoning, 1.75, LineStyle::kDashed};
constexpr Stroke kTruth{palette::kTruth, 7, LineStyle::kSolid};
constexpr Stroke kSight{{106, 81, 163}, 2, LineStyle::kDashed};
constexpr Color kTrueLandmark{110, 110, 110};
constexpr Stroke kAcceptedClosure{{0, 158, 115}, 1.75, LineStyle::kSolid};
constexpr Stroke kUndecidedClosure{{154, 117, 0}, 1.75, LineStyle::kDotted};
constexpr Stroke kRejectedClosure{{204, 121, 167}, 1.75, LineStyle::kDashed};
constexpr Color kWall{70, 70, 70}, kFreeFloor{236, 240, 244};
constexpr Stroke kMover{{200, 30, 120}, 2, LineStyle::kSolid};
constexpr Color kGoodFix{86, 180, 233}, kBiasedFix{154, 117, 0}, kFalseFix{136, 34, 85};
constexpr Color kUnusedFix{150, 150, 150};
/// Motions of modes other than the first, drawn over the estimate.
inline Stroke mode_stroke(int mode) {
  return {mode_color(static_cast<std::size_t>(mode)), 7, LineStyle::kSolid};
}
constexpr double kSigmas = 3;  ///< standard deviations of ellipses
}  // namespace map_style

/// The estimated path of a robot as it is drawn.
struct DrawnPath {
  std::string name;
  std::vector<Eigen::Vector3d> points;
  Stroke stroke;
};

/// The points of a path over these keyframes, which are all of robot number `robot`.
std::vector<Eigen::Vector3d> drawn_points(const Trajectory& all, const PathCurves& curves,
                                          const std::vector<std::size_t>& keyframes,
                                          std::size_t robot);
/// The numbers of all keyframes of a path.
std::vector<std::size_t> keyframes_of(const Trajectory& path);

/// Those of all robots that have poses, each in its colour; of one robot, its path as "estimated".
std::vector<DrawnPath> drawn_paths(const MapResult& result);
/// "the robot", or how many robots and, where robots have no names, sessions there are.
std::string whose(const MapResult& result);
/// Whether a picture counts landmarks: a map of laser scans alone has none to count.
bool lists_landmarks(const MapResult& result);
/// "742 poses of the robot, 15 landmarks".
std::string contents_of(const MapResult& result);
/// The true paths that are known.
std::vector<Trajectory> true_paths(const GroundTruth& truth);

/// Colour and shape of a landmark's class.
Color landmark_color(const LandmarkEstimate& landmark);
/// Probability of its most probable class; 1 if there are no classes.
double class_probability(const LandmarkEstimate& landmark);
/// The colour of the class with its probability as opacity, on white.
Color landmark_fill(const LandmarkEstimate& landmark);
Marker landmark_marker(const LandmarkEstimate& landmark);

/// Bounds in metres.
struct Extent {
  Eigen::Array3d low = Eigen::Array3d::Constant(1e300);
  Eigen::Array3d high = Eigen::Array3d::Constant(-1e300);

  void add(const Eigen::Vector3d& point);
  void add(const std::vector<Eigen::Vector3d>& points);
  void add(const Trajectory& path);
  bool empty() const { return low.x() > high.x(); }
};

/// Bounds of estimate, truth and landmarks, and of what scans saw as long as that does not make the
/// picture more than half as large again on any side. Dead reckoning and fixes are cut where they
/// leave them. Never empty, at least half a metre wide.
Extent map_extent(const MapResult& result, const GroundTruth& truth);

/// Extent and scale of a picture of a map, shared by pictures that belong together.
struct MapFrame {
  Extent extent;
  double magnification = 1;  ///< of ellipses
};

/// The frame of the whole map, with ellipses large enough to see.
MapFrame map_frame(const MapResult& result, const GroundTruth& truth);

/// Whether the estimate covers dead reckoning everywhere, in a picture of this extent.
bool is_hidden(const Trajectory& dead_reckoning, const Trajectory& estimate, const Extent& extent);

/// A round factor that makes the typical covariance ellipse large enough to see in a picture of a
/// scene of `size` metres; 1 if it already is.
double ellipse_magnification(const std::vector<LandmarkEstimate>& landmarks, double size);

/// The sentence of the legend about the magnification.
std::string ellipse_note(double magnification);

}  // namespace hybrid
