// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/closures/closure_decision.h"
#include "libhybrid/clouds/cloud_points.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/landmarks/known_map.h"
#include "libhybrid/movers/mover.h"
#include "libhybrid/smoother/report.h"
#include "mrpt_plugins/bridge/geodesy.h"
#include "mrpt_plugins/bridge/timed_pose.h"
#include "mrpt_plugins/mapping/grid_map.h"

namespace HYBRID_API hybrid {

/// The reason under which steps without odometry are counted.
inline constexpr const char* kOdometryMissing = "odometry missing: robot taken to stand still";

/// One landmark of the map: mean (m) and covariance (m^2) in the map frame, and class.
struct LandmarkEstimate {
  std::int64_t id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< third row and column zero in 2-D
  bool is_3d = false;
  std::optional<int> class_index;           ///< most probable class, into MapResult::class_names
  std::vector<double> class_probabilities;  ///< one per class name; empty when there are no classes
  int sightings = 0;
  LandmarkSize size;
};

/// One thing that moves: no landmark, but a trajectory of its own.
struct MoverEstimate : Mover {
  std::vector<std::size_t> keyframes;  ///< of the states
  std::optional<int> class_index;      ///< most probable class, into MapResult::class_names
};

/// Work of the solver for one keyframe, one line of steps.csv.
struct StepRecord : UpdateWork {
  std::int64_t keyframe = 0;   ///< its number, or the id of a pose in its file
  double time = 0;             ///< time stamp of the keyframe, s
  double plugin_ms = 0;        ///< wall time of the plugins, association included
  double cost = 0;             ///< half the weighted squared error of the continuous factors
  std::size_t landmarks = 0;   ///< in the map after the step
  std::size_t robot = 0;       ///< of several, the one whose keyframe it is
  bool has_detections = true;  ///< a detector looked there, and may have seen nothing
};

/// Estimated parameters of the robot: the pose of a sensor, or scale and drift of odometry.
struct CalibrationEstimate {
  struct Entry {
    std::string name, unit;
    double value = 0, sigma = 0;  ///< in the unit
    double start = 0;
    std::optional<double> logged = std::nullopt;  ///< value in the log
    /// False if the measurements do not determine it: the value is that of the prior then.
    bool observed = false;
  };
  std::string name;
  std::vector<Entry> entries;
};

/// One of several robots of a map.
struct RobotPath {
  std::string name;
  std::vector<std::size_t> keyframes;  ///< its own, places in MapResult::trajectory
  bool is_session = false;             ///< of a robot without a name: that of a session instead
};

/// A closure between keyframes that may be false.
struct ScanClosureEstimate {
  std::size_t from = 0, to = 0;  ///< keyframes, places in MapResult::trajectory
  ClosureDecision decision;
  double inliers = 0.0;  ///< share of the points that lie on surfaces
  int modes = 1;         ///< poses that the same search found
};

/// The same with the pose that was measured.
template <class Pose>
struct MeasuredClosure : ScanClosureEstimate {
  Pose T_from_to;
};

enum class FixMode { kGood, kBiased, kFalse };

/// One fix of a satellite receiver.
struct FixEstimate {
  double time = 0;
  std::size_t keyframe = 0;  ///< of the trajectory, which it belongs to
  std::string sensor;        ///< label of the receiver
  /// Where the receiver says that it is, in the map [m]; the other is where the map says that it
  /// is.
  Eigen::Vector3d measured = Eigen::Vector3d::Zero(), antenna = Eigen::Vector3d::Zero();
  double sigma = 0;                                 ///< as stated [m]
  Eigen::Vector3d error = Eigen::Vector3d::Zero();  ///< that lasts: east, north, up [m]
  std::optional<FixMode> mode;                      ///< nothing where it is not in the map
  std::array<double, 3> probabilities{};            ///< of the modes; zero where not known
  std::string unused;                               ///< why it is not in the map
};

/// Where a map is on earth.
struct MapDatum {
  GeodeticPoint origin;
  bool is_on_earth = true;  ///< else the origin stands for that of another frame
  Eigen::Isometry3d T_datum_map = Eigen::Isometry3d::Identity();
};

/// Points of paths between keyframes, as they are drawn.
struct PathCurves {
  /// To each keyframe, from the one before of its robot; empty: a straight line.
  std::vector<std::vector<Eigen::Vector3d>> to;
  std::vector<std::vector<Eigen::Vector3d>> after;  ///< of each robot, after its last keyframe
};

/// Everything a replay produces that the writers and the pictures need.
struct MapResult {
  std::string title;  ///< name of the log or configuration, for headings
  bool is_3d = false;
  bool has_odometry = true;              ///< to any keyframe
  bool in_known_map = false;             ///< else the map frame is that of the first pose
  std::vector<std::string> class_names;  ///< empty when landmarks have no class
  Trajectory trajectory;                 ///< of all robots, in the order of time
  Trajectory dead_reckoning;
  PathCurves curves, reckoned_curves;  ///< of these; empty where both are straight between poses
  std::vector<RobotPath> robots;       ///< empty where there is but one without a name
  std::vector<LandmarkEstimate> landmarks;
  std::vector<MoverEstimate> movers;
  std::vector<FixEstimate> fixes;
  std::optional<MapDatum> datum;
  std::vector<StepRecord> steps;
  std::vector<CalibrationEstimate> calibration;
  std::vector<std::string> mode_names;  ///< of motion; empty when motion has no modes
  std::vector<int> motion_modes;        ///< mode of the motion to each pose; -1: none
  std::vector<std::vector<double>> mode_probabilities;  ///< of these modes; empty where not known
  std::shared_ptr<const GridMap> grid;  ///< of laser scans; null where none are kept
  std::vector<ScanClosureEstimate> scan_closures;
  /// What clouds of lidars and depth cameras saw, in the map; null where none were mapped.
  std::shared_ptr<const std::vector<CloudPoint>> cloud;
};

/// The poses of one robot.
inline Trajectory part_of(const Trajectory& all, const RobotPath& robot) {
  Trajectory out;
  for (const std::size_t i : robot.keyframes) out.push_back(all[i]);
  return out;
}

/// A landmark as the ground truth knows it, position in metres.
struct TrueLandmark {
  std::int64_t id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::optional<int> class_index;
};

/// Where things that really move were, by true id and step of the log [m].
using TrueMovers = std::map<std::int64_t, std::map<std::size_t, Eigen::Vector3d>>;

/// The ground truth; each part may be empty.
struct GroundTruth {
  Trajectory path;
  std::vector<Trajectory> others;  ///< paths of the other robots, where there are several
  std::vector<TrueLandmark> landmarks;
  TrueMovers movers;
};

}  // namespace hybrid
