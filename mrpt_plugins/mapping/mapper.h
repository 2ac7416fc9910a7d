// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <array>
#include <cstddef>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/landmarks/landmark_registry.h"
#include "mrpt_plugins/input/keyframe_source.h"
#include "mrpt_plugins/mapping/backend.h"
#include "mrpt_plugins/mapping/calibration.h"
#include "mrpt_plugins/mapping/map_change.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"
#include "mrpt_plugins/mapping/motion.h"
#include "mrpt_plugins/mapping/robot_sightings.h"

namespace HYBRID_API hybrid {

class FixSource;

/// A robot of a map that several make.
struct RobotOptions {
  std::string name;                ///< empty where there is but one
  std::optional<std::int64_t> id;  ///< that sensors of the other robots give it
  MotionOptions motion;
  CalibrationOptions calibration;
  /// Whether each plugin gets to see what this robot observes; empty: all do.
  std::vector<bool> plugins;
};

/// A mapper has done more than it may.
struct TooMuchWork : std::exception {
  const char* what() const noexcept override { return "the map takes more work than it may"; }
};

/// The main loop of mapping: one keyframe in, one Delta to the back-end, one record out. Poses are
/// numbered by keyframe, whichever robot they are of.
class Mapper {
 public:
  /// `is_3d`: SE(3) poses and 3-D points, else SE(2) poses and 2-D points.
  Mapper(const MotionOptions& options, std::vector<std::shared_ptr<MappingPlugin>> plugins,
         std::unique_ptr<Backend> backend, bool is_3d, const CalibrationOptions& calibration = {});
  /// The same for several robots, one map of landmarks. The first starts at the origin, the others
  /// where MotionOptions::start says. `loss` is that of sightings of robots by robots. Throws Error
  /// where the options do not go together.
  Mapper(std::vector<RobotOptions> robots, std::vector<std::shared_ptr<MappingPlugin>> plugins,
         std::unique_ptr<Backend> backend, bool is_3d, Loss loss = {});

  /// Adds known landmarks before the first keyframe. Throws Error if their classes are not those of
  /// the plugins.
  void adopt(const KnownMap& known);
  /// The map that was adopted is there on earth.
  void adopt(const MapDatum& datum);
  /// Gives up what was known of the start (MotionOptions::start) of a robot, once measurements say
  /// where it is.
  void forget_start(std::size_t robot = 0);
  /// Log odds that landmarks are there, by id, as far as plugins tell.
  std::map<std::int64_t, double> existence() const;

  /// Adds one keyframe. Unusable parts (odometry that makes no sense, observations that leave a
  /// variable undetermined, contributions of a plugin that throws) are left out and counted in
  /// `dropped`. Nothing, and counted too, where the back-end refuses the pose alone: the next
  /// motion of this robot then begins at the keyframe before. Throws SettingsError if the options
  /// contradict each other, Error where no first pose is possible, and std::bad_alloc, which leaves
  /// the map unchanged.
  const StepRecord* add(const Keyframe& raw);

  /// Solves to convergence.
  BackendReport finish();

  /// What all updates have done: factors linearised and variables eliminated, which are the same on
  /// any machine.
  double work() const { return work_; }
  /// From now on `add` and `finish` throw TooMuchWork where that exceeds `most`; the mapper is of
  /// no use then.
  void limit_work(double most) { most_work_ = most; }

  /// Trajectory, dead reckoning, landmarks with covariance and class, and the steps.
  MapResult result() const;
  /// The same, but what landmarks stand for (LandmarkEstimate::size) is not asked of the plugins,
  /// which look at all sightings for that.
  MapResult result_without_sizes() const;

  /// Row of MRPT's ground truth path for each pose of the trajectory.
  const std::vector<std::size_t>& log_rows() const { return log_rows_; }
  /// Time of a pose [s].
  double time_of(std::size_t pose) const { return steps_[pose].time; }
  /// All poses as they are estimated now.
  Trajectory trajectory() const;
  /// Of which robot a pose is.
  std::size_t robot_of(std::size_t pose) const { return steps_[pose].robot; }
  /// Where a sensor of a robot sits by its estimate; nothing if it is not calibrated.
  std::optional<Eigen::Isometry3d> calibrated_sensor(std::size_t robot,
                                                     const std::string& label) const {
    return robots_[robot].calibrator.sensor(label, backend_->values());
  }
  /// Names of the robots; empty where there is but one without a name.
  std::vector<std::string> robot_names() const;
  /// Tangent covariance of each pose, 3x3 or 6x6, at the present estimate; empty if not known.
  std::vector<Eigen::MatrixXd> pose_covariances() const;

  /// Attribution of every detection, from the plugins that associate.
  std::vector<AssociationDecision> decisions() const;

  const Backend& backend() const { return *backend_; }
  const LandmarkRegistry& landmarks() const { return landmarks_; }
  /// Figures of all plugins (see MappingPlugin), the number of solver calls, and how many of them
  /// used local search instead of exact discrete inference.
  std::map<std::string, double> statistics() const;
  /// Starts recording every change of the map for `take_events`.
  void keep_events() { events_.emplace(); }
  /// Changes since the last call, in order; empty unless keep_events() was called.
  std::vector<MapChange> take_events();
  /// Reason -> number of measurements that were not used.
  std::map<std::string, std::size_t> dropped() const;
  /// What exactly was wrong with the first of them, by step of the log.
  const std::vector<std::string>& warnings() const { return warnings_; }
  bool is_3d() const { return is_3d_; }
  /// Number of factors that the plugins, and robots that met, have put into the map, without those
  /// taken back: 0 where the path is dead reckoning.
  std::size_t measurements() const { return measurements_; }
  /// Names of the classes of landmarks; empty if they have none, or none was seen yet.
  std::vector<std::string> class_names() const;

 private:
  /// A robot and how far it is.
  struct Robot {
    RobotOptions options;
    Calibrator calibrator;
    std::optional<DiscreteKey> last_mode;   // of the newest motion
    std::optional<Handle> start;            // of what is known of the first pose in a known map
    std::vector<std::size_t> poses;         // keyframes
    mrpt::poses::CPose3D T_odometry_robot;  // dead reckoning of the newest
    std::optional<OdometryIncrement>
        since;  // motion from the newest to a keyframe that was dropped
  };
  /// A new pose on its way into the map.
  struct Motion {
    Delta delta;
    mrpt::poses::CPose3D T_map_robot, T_odometry_robot;  ///< predicted, and by odometry alone
    ContinuousFactorPtr factor;                          ///< motion to it, or its prior
    std::optional<DiscreteKey> mode;
  };

  Motion predict(Keyframe& keyframe);
  Motion predict_from(const OdometryIncrement* measured) const;
  void add_motion(Key to, const OdometryIncrement& motion, bool measured, Motion& out) const;
  void add_sightings(const Keyframe& keyframe, Delta& delta);
  void take_sightings(const Keyframe& keyframe);
  std::optional<BackendReport> update_by(Motion& motion, bool is_measured,
                                         const std::vector<Contribution>& contributions);
  Robot& robot() { return robots_[robot_]; }
  const Robot& robot() const { return robots_[robot_]; }
  void add_modes(MapResult& result) const;
  void add_movers(MapResult& result) const;
  void add_fixes(MapResult& result) const;
  std::vector<Contribution> observe(const Keyframe& keyframe, const Motion& motion);
  std::vector<Contribution> ask(const std::function<Contribution(std::size_t)>& question);
  MapView view() const;
  void note(const std::string& reason, const std::string& what);
  void refuse(std::size_t plugin, const std::string& reason);
  void refuse_from(std::size_t plugin);
  BackendReport update(const Delta& delta, const std::vector<Contribution>& contributions);
  BackendReport update_one_by_one(const Delta& delta,
                                  const std::vector<Contribution>& contributions);
  void tell(std::size_t plugin, const Contribution& contribution, const BackendReport& report,
            std::array<std::size_t, 3>& first);
  void note_start(const Delta& motion, const BackendReport& report);
  FixSource* fix_source() const;
  void look_for_datum(bool is_last = false);
  void set_start(Robot& robot, const KnownStart& start);
  void count(const BackendReport& report);
  void count_work(const BackendReport& report);
  void keep(const BackendReport& report);
  void keep(const Contribution& contribution);
  void keep_turned_down(const Contribution& contribution);
  BackendReport solve(BackendReport (Backend::*way)());
  BackendReport revise(bool concluding);
  StepRecord record(const Keyframe& keyframe, const BackendReport& report) const;
  Key pose_key(std::size_t i) const { return Key(key_letter::kPose, i); }

  std::vector<Robot> robots_;
  std::size_t robot_ = 0;  // of the newest keyframe
  RobotSightings sightings_;
  std::map<std::int64_t, std::size_t> robot_of_;  // ids that sensors give
  std::vector<std::shared_ptr<MappingPlugin>> plugins_;
  std::unique_ptr<Backend> backend_;
  bool is_3d_;
  LandmarkRegistry landmarks_;
  std::map<std::string, std::size_t> dropped_;
  std::vector<std::string> warnings_;
  std::vector<StepRecord> steps_;
  Trajectory dead_reckoning_;
  std::vector<std::size_t> log_rows_;
  bool may_find_datum_ = true;
  bool has_motion_ = false;  // of odometry or scans
  std::size_t updates_ = 0, updates_by_local_search_ = 0;
  std::size_t row_ = 0;       // of the log, of the newest keyframe
  std::size_t refusals_ = 0;  // contributions refused so far
  std::size_t measurements_ = 0;
  double plugin_ms_ = 0;  // time of the plugins for the newest keyframe
  double objective_ = 0;
  double work_ = 0, most_work_ = std::numeric_limits<double>::infinity();
  std::optional<std::vector<MapChange>> events_;  // if recorded
};

}  // namespace hybrid
