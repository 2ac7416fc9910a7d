// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/map_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "libhybrid/core/quantile.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/report/columns.h"
#include "mrpt_plugins/report/fix_json.h"
#include "mrpt_plugins/report/graph_report.h"
#include "mrpt_plugins/report/history_json.h"
#include "mrpt_plugins/report/scan_json.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostTruePoses = 10000;  // of the drawn path
constexpr double kGap = 20;                    // median intervals over which no line is drawn

Json point_json(const Eigen::Vector3d& point, bool is_3d) {
  Json out = {decimals(point.x()), decimals(point.y())};
  if (is_3d) out.push_back(decimals(point.z()));
  return out;
}

Json landmarks_json(const MapResult& result) {
  Json out = Json::array();
  for (const LandmarkEstimate& l : result.landmarks) {
    Json covariance = {digits(l.covariance(0, 0)), digits(l.covariance(0, 1)),
                       digits(l.covariance(1, 1))};
    if (result.is_3d) {
      for (int i = 0; i < 3; ++i) covariance.push_back(digits(l.covariance(i, 2)));
    }
    out.push_back({{"id", l.id},
                   {"at", point_json(l.position, result.is_3d)},
                   {"covariance", covariance},
                   {"class", or_null(l.class_index)},
                   {"p", decimals(l.class_probabilities, 6)},
                   {"sightings", l.sightings}});
    if (l.size.extent > 0) out.back()["extent"] = digits(l.size.extent);
    if (l.size.things > 1) out.back()["things"] = l.size.things;
  }
  return out;
}

/// Of the times of a path; infinite where it has none.
double median_interval(const Trajectory& path) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (path[i].time > path[i - 1].time) intervals.push_back(path[i].time - path[i - 1].time);
  }
  if (intervals.empty()) return std::numeric_limits<double>::infinity();
  return median(std::move(intervals));
}

/// Adds a true path, with gaps before it and where it was not known, as without satellites.
void add_path(const Trajectory& known, std::vector<Eigen::Vector3d>& path) {
  const Eigen::Vector3d gap = Eigen::Vector3d::Constant(std::nan(""));
  if (!path.empty()) path.push_back(gap);
  const std::size_t every = 1 + known.size() / kMostTruePoses;
  const double longest = kGap * median_interval(known);
  for (std::size_t i = 0; i < known.size(); i += every) {
    const bool lost =
        i > 0 && known[i].time - known[i - every].time > longest * static_cast<double>(every);
    if (lost) path.push_back(gap);
    path.push_back(point_of(known[i].pose));
  }
}

/// The true paths and landmarks.
Json truth_json(const GroundTruth& truth, bool is_3d) {
  std::vector<Eigen::Vector3d> path;
  add_path(truth.path, path);
  for (const Trajectory& other : truth.others) add_path(other, path);
  Json landmarks = Json::array();
  for (const TrueLandmark& l : truth.landmarks) {
    landmarks.push_back(
        {{"id", l.id}, {"at", point_json(l.position, is_3d)}, {"class", or_null(l.class_index)}});
  }
  return {{"path", coordinates(path, is_3d)}, {"landmarks", landmarks}};
}

double distance(const mrpt::poses::CPose3D& a, const mrpt::poses::CPose3D& b) {
  return (point_of(a) - point_of(b)).norm();
}

/// Errors of position over time, of each robot: of the estimate as it is and after the best rigid
/// motion of all paths onto the truth, and of odometry alone. After that motion also as vectors
/// `off`, with the way driven, by which the page compares poses some way apart.
Json errors_json(const MapReport& report) {
  std::vector<PosePair> all;
  for (const PathPairs& path : report.paths) {
    all.insert(all.end(), path.estimated.begin(), path.estimated.end());
  }
  Json out = Json::array();
  if (all.empty()) return out;
  const mrpt::poses::CPose3D T = alignment(all);
  for (const PathPairs& path : report.paths) {
    Json own = {{"robot", path.robot}};
    own.update(empty_columns({"t", "estimate", "aligned", "reckoned", "off", "way"}));
    double way = 0;
    for (std::size_t i = 0; i < path.estimated.size(); ++i) {
      const PosePair& pair = path.estimated[i];
      own["t"].push_back(decimals(path.times[i] - report.result.trajectory.front().time, 3));
      own["estimate"].push_back(decimals(distance(pair.estimate, pair.truth)));
      const Eigen::Vector3d off = point_of(T + pair.estimate) - point_of(pair.truth);
      own["aligned"].push_back(decimals(off.norm()));
      own["off"].push_back({decimals(off.x()), decimals(off.y()), decimals(off.z())});
      if (i > 0) way += distance(pair.truth, path.estimated[i - 1].truth);
      own["way"].push_back(decimals(way));
      if (i >= path.reckoned.size()) continue;
      own["reckoned"].push_back(
          decimals(distance(path.reckoned[i].estimate, path.reckoned[i].truth)));
    }
    out.push_back(std::move(own));
  }
  return out;
}

/// The robots, and which of them each pose is of; no names where there is but one without a name.
Json robots_json(const MapResult& result) {
  std::vector<std::string> names;
  std::vector<std::size_t> of(result.robots.empty() ? 0 : result.trajectory.size());
  for (const RobotPath& robot : result.robots) {
    for (const std::size_t i : robot.keyframes) of[i] = names.size();
    names.push_back(robot.name);
  }
  return {{"names", names}, {"of", of}};
}

/// What is drawn between keyframes; nothing where paths are straight there.
void add_curves(const char* name, const PathCurves& curves, bool is_3d, Json& out) {
  if (curves.to.empty()) return;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::size_t> counts;
  for (const std::vector<Eigen::Vector3d>& piece : curves.to) {
    counts.push_back(piece.size());
    points.insert(points.end(), piece.begin(), piece.end());
  }
  Json own = coordinates(points, is_3d);
  own["n"] = counts;
  own["after"] = Json::array();
  for (const std::vector<Eigen::Vector3d>& piece : curves.after) {
    own["after"].push_back(coordinates(piece, is_3d));
  }
  out[name] = std::move(own);
}

}  // namespace

Json map_report_json(const MapReport& report) {
  const MapResult& result = report.result;
  const Trajectory& path = result.trajectory;
  Json out = {
      {"schema", 1},
      {"kind", "map"},
      {"title", result.title},
      {"start", path.empty() ? Json() : decimals(path.front().time, 6)},
      {"dimension", result.is_3d ? 3 : 2},
      {"classes", result.class_names},
      {"robots", robots_json(result)},
      {"poses", pose_columns(path, result.is_3d)},
      {"reckoned", pose_columns(result.dead_reckoning, result.is_3d)},
      {"landmarks", landmarks_json(result)},
      {"truth", truth_json(report.truth, result.is_3d)},
      {"steps", steps_json(result.steps)},
      {"errors", errors_json(report)},
      {"modes", {{"names", result.mode_names}, {"of", result.motion_modes}}},
      {"photographs", report.photographs},
      {"scans", report.views.empty() ? scans_json(report.scans) : views_json(report.views, path)},
      {"scan_closures", scan_closures_json(result.scan_closures)},
      {"fixes", fixes_json(result)},
      {"summary", report.summary}};
  add_curves("curves", result.curves, result.is_3d, out);
  add_curves("reckoned_curves", result.reckoned_curves, result.is_3d, out);
  out.update(history_json(report.record, result.is_3d));
  return out;
}

}  // namespace hybrid
