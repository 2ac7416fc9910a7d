// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/mapper.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/motion_covariance.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/mapping/fix_source.h"
#include "mrpt_plugins/mapping/scan_follower.h"

namespace hybrid {
namespace {

/// Reserves memory, so that the next push_back cannot throw.
template <class T>
void make_room(std::vector<T>& list) {
  if (list.size() == list.capacity()) list.reserve(2 * list.size() + 1);
}

/// Odometry with another motion and covariance in the plane.
OdometryIncrement in_plane(OdometryIncrement odometry, const UncertainMotion& measured) {
  mrpt::poses::CPose3D& mean = odometry.mean;
  const SE2& motion = measured.motion;
  mean.setFromValues(motion.x(), motion.y(), mean.z(), motion.angle(), mean.pitch(), mean.roll());
  for (const int i : kPlanarIndices) {
    odometry.covariance.row(i).setZero();
    odometry.covariance.col(i).setZero();
  }
  odometry.covariance += planar_to_6d(measured.covariance);
  add_noise_floor(odometry);
  return odometry;
}

/// The factor of odometry in a change; null where odometry has modes or a calibration.
ContinuousFactorPtr* logged_motion_in(Delta& delta, Key from, Key to) {
  const auto found = std::find_if(
      delta.continuous.begin(), delta.continuous.end(), [&](const ContinuousFactorPtr& factor) {
        return factor->keys().size() == 2 && factor->keys()[0] == from && factor->keys()[1] == to;
      });
  return found == delta.continuous.end() ? nullptr : &*found;
}

/// Where matches of scans have measured scale, drift and noise of odometry, these take the place of
/// what the log says; that of the noise, if the settings do not.
void use_measured_odometry(const std::vector<std::shared_ptr<MappingPlugin>>& plugins,
                           const OdometryIncrement& logged, const MotionOptions& options,
                           bool is_3d, ContinuousFactorPtr& factor) {
  for (const auto& plugin : plugins) {
    const auto* follower = dynamic_cast<const ScanFollower*>(plugin.get());
    if (follower == nullptr) continue;
    const std::optional<ScanMotion> motion = follower->scan_motion();
    if (!motion || !motion->odometry) continue;
    factor = odometry_factor(factor->keys()[0], factor->keys()[1],
                             in_plane(logged, *motion->odometry), options, is_3d);
    return;
  }
}

bool follow_scans(const std::vector<std::shared_ptr<MappingPlugin>>& plugins) {
  return std::any_of(plugins.begin(), plugins.end(), [](const auto& plugin) {
    return dynamic_cast<const ScanFollower*>(plugin.get()) != nullptr;
  });
}

bool tie_keyframes(const std::vector<std::shared_ptr<MappingPlugin>>& plugins) {
  return std::any_of(plugins.begin(), plugins.end(),
                     [](const auto& plugin) { return plugin->ties_keyframes(); });
}

}  // namespace

Mapper::Mapper(const MotionOptions& options, std::vector<std::shared_ptr<MappingPlugin>> plugins,
               std::unique_ptr<Backend> backend, bool is_3d, const CalibrationOptions& calibration)
    : Mapper(std::vector<RobotOptions>{{"", std::nullopt, options, calibration, {}}},
             std::move(plugins), std::move(backend), is_3d) {}

Mapper::Mapper(std::vector<RobotOptions> robots,
               std::vector<std::shared_ptr<MappingPlugin>> plugins,
               std::unique_ptr<Backend> backend, bool is_3d, Loss loss)
    : sightings_(loss), plugins_(std::move(plugins)), backend_(std::move(backend)), is_3d_(is_3d) {
  if (robots.size() > 1 && !backend_->keeps_all()) {
    throw SettingsError("several robots need [solver] mode = bounded, incremental or batch, not " +
                        backend_->mode());
  }
  const std::size_t modes = robots.front().motion.modes.size();
  for (RobotOptions& options : robots) {
    check(options.motion, is_3d_);
    if (options.motion.modes.size() != modes) {
      throw SettingsError("[motion] modes must be the same for all robots");
    }
    const std::size_t number = robots_.size();
    if (options.id && !robot_of_.emplace(*options.id, number).second) {
      throw SettingsError(fmt::format("two robots have the id {}", *options.id));
    }
    Calibrator calibrator(options.calibration, is_3d_, options.name, number);
    robots_.push_back({std::move(options), std::move(calibrator), {}, {}, {}, {}, {}});
  }
}

const StepRecord* Mapper::add(const Keyframe& raw) {
  Keyframe keyframe = raw;
  make_room(steps_);
  make_room(log_rows_);
  make_room(dead_reckoning_);
  plugin_ms_ = 0;
  row_ = raw.row;
  robot_ = raw.robot;
  make_room(robot().poses);
  if (robot().since && keyframe.odometry) {
    keyframe.odometry = compose(*robot().since, *keyframe.odometry);
  }
  Motion motion = predict(keyframe);
  robot().calibrator.place_sensors(keyframe.detections, backend_->values(), motion.delta);
  add_sightings(keyframe, motion.delta);
  const std::vector<Contribution> contributions = observe(keyframe, motion);
  if (keyframe.odometry && !robot().poses.empty()) {
    ContinuousFactorPtr* const factor =
        logged_motion_in(motion.delta, pose_key(robot().poses.back()), pose_key(steps_.size()));
    if (factor != nullptr) {
      use_measured_odometry(plugins_, *keyframe.odometry, robot().options.motion, is_3d_, *factor);
    }
  }
  const std::optional<BackendReport> report =
      update_by(motion, keyframe.odometry.has_value(), contributions);
  if (!report) {
    robot().since =
        keyframe.odometry ? *keyframe.odometry : unknown_motion(robot().options.motion, is_3d_);
    return nullptr;
  }
  robot().since.reset();
  take_sightings(keyframe);
  const bool is_matched = !keyframe.scans.empty() && follow_scans(plugins_);
  if ((is_matched || tie_keyframes(plugins_)) && backend_->keeps_all()) {
    backend_->hold(pose_key(steps_.size()));
  }
  has_motion_ = has_motion_ || keyframe.odometry;
  robot().last_mode = motion.mode;
  robot().T_odometry_robot = motion.T_odometry_robot;
  robot().poses.push_back(steps_.size());
  dead_reckoning_.push_back({keyframe.time, motion.T_odometry_robot});
  log_rows_.push_back(keyframe.row);
  steps_.push_back({});
  look_for_datum();
  BackendReport work = *report;
  add_work(work, revise(false));
  steps_.back() = record(keyframe, work);
  return &steps_.back();
}

/// The update by a keyframe: without its odometry where that is refused, too, and nothing where the
/// pose is refused alone.
std::optional<BackendReport> Mapper::update_by(Motion& motion, bool is_measured,
                                               const std::vector<Contribution>& contributions) {
  try {
    return update(motion.delta, contributions);
  } catch (const Error& e) {
    if (steps_.empty()) throw Error(fmt::format("step {} of the log: {}", row_, e.what()));
    if (!is_measured) {
      note("keyframe dropped: not usable", e.what());
      return std::nullopt;
    }
    note("odometry dropped: not usable", e.what());
  }
  motion = predict_from(nullptr);
  return update_by(motion, false, {});
}

/// The motion to a new pose. Unusable odometry is dropped.
Mapper::Motion Mapper::predict(Keyframe& keyframe) {
  if (!robot().poses.empty() && !keyframe.odometry) {
    ++dropped_[kOdometryMissing];
  }
  try {
    return predict_from(keyframe.odometry ? &*keyframe.odometry : nullptr);
  } catch (const Error& e) {
    if (!keyframe.odometry) throw;  // the options are at fault
    note("odometry dropped: not usable", e.what());
    keyframe.odometry.reset();
    return predict_from(nullptr);
  }
}

Mapper::Motion Mapper::predict_from(const OdometryIncrement* measured) const {
  Motion out;
  const MotionOptions& options = robot().options.motion;
  const Key newest = pose_key(steps_.size());
  if (robot().poses.empty()) {
    out.factor = origin_factor(newest, options, is_3d_);
    out.delta.continuous.push_back(out.factor);
    if (options.start) {
      out.T_map_robot = to_mrpt(options.start->T_map_robot);
      out.T_odometry_robot = out.T_map_robot;
    }
  } else {
    const Key before = pose_key(robot().poses.back());
    const OdometryIncrement motion =
        measured != nullptr ? *measured : unknown_motion(options, is_3d_);
    add_motion(newest, motion, measured != nullptr, out);
    out.T_map_robot = pose_at(backend_->values(), before) +
                      robot().calibrator.corrected(motion.mean, backend_->values());
    out.T_odometry_robot = robot().T_odometry_robot + motion.mean;
  }
  insert_pose(out.delta.values, newest, out.T_map_robot, is_3d_);
  return out;
}

/// The factors of the motion to a pose. Where odometry is missing it has no mode and no
/// calibration.
void Mapper::add_motion(Key to, const OdometryIncrement& motion, bool measured, Motion& out) const {
  const std::vector<std::size_t>& poses = robot().poses;
  const MotionOptions& options = robot().options.motion;
  const Key from = pose_key(poses.back());
  Delta& delta = out.delta;
  const std::optional<Key> calibration =
      measured ? robot().calibrator.odometry(backend_->values(), delta) : std::nullopt;
  out.factor = odometry_factor(from, to, motion, options, is_3d_, calibration);
  if (options.modes.empty() || !measured) {
    delta.continuous.push_back(out.factor);
  } else {
    const DiscreteKey mode{Key(key_letter::kMotionMode, to.index()),
                           static_cast<int>(options.modes.size())};
    delta.hybrid.push_back(switching_factor(mode, from, to, motion, options, is_3d_, calibration));
    delta.discrete.push_back(robot().last_mode ? chain_step(options.chain, *robot().last_mode, mode)
                                               : chain_tables(options.chain, {mode}).front());
    out.mode = mode;
  }
  if (options.steady_sigma_m > 0 && poses.size() >= 2) {
    const Key earlier = pose_key(poses[poses.size() - 2]);
    delta.continuous.push_back(steady_factor(earlier, from, to, options, is_3d_));
  }
}

/// Adds what other robots have seen of this one since its last keyframe.
void Mapper::add_sightings(const Keyframe& keyframe, Delta& delta) {
  if (robots_.size() == 1) return;
  if (robot().poses.empty() || !keyframe.odometry) {
    sightings_.miss(robot_, keyframe.time);
    return;
  }
  const std::size_t before = robot().poses.back();
  const RobotMotion motion{pose_key(before), steps_[before].time, keyframe.time,
                           to_isometry(keyframe.odometry->mean), keyframe.odometry->covariance};
  for (ContinuousFactorPtr& factor :
       sightings_.met(robot_, motion, backend_->values(), is_3d_,
                      [this](Key key) { return backend_->holds(key); })) {
    delta.continuous.push_back(std::move(factor));
    ++measurements_;
  }
}

/// Notes what a robot sees of others, from the pose that was added last.
void Mapper::take_sightings(const Keyframe& keyframe) {
  if (robots_.size() == 1) return;
  sightings_.take(robot_, pose_key(steps_.size()), keyframe.time, keyframe.robots, robot_of_);
}

MapView Mapper::view() const {
  MapView view{backend_->values(), backend_->assignment(), landmarks_, is_3d_};
  view.keeps_all = backend_->keeps_all();
  view.explain = events_.has_value();
  view.holds = [this](Key key) { return backend_->holds(key); };
  view.joint_covariance = [this](const std::vector<Key>& keys) {
    return backend_->joint_covariance(keys);
  };
  view.covariance_of = [this](const std::vector<Key>& keys, const Eigen::MatrixXd& J) {
    return backend_->joint_covariance(keys, J);
  };
  return view;
}

/// Calls observe() of each plugin; a plugin that throws contributes nothing.
std::vector<Contribution> Mapper::observe(const Keyframe& keyframe, const Motion& motion) {
  Frame frame{pose_key(steps_.size()),
              motion.T_map_robot,
              keyframe.detections,
              keyframe.observations,
              keyframe.scans,
              {},
              {},
              keyframe.fixes,
              robot_,
              keyframe.odometry.has_value()};
  const MapView map = view();
  const MotionCovariance after(*motion.factor, frame.pose, motion.delta.values, backend_->values(),
                               map.covariance_of);
  frame.joint_covariance = after;
  frame.covariance_of = after;
  const std::vector<bool>& seeing = robot().options.plugins;
  for (const auto& plugin : plugins_) {
    auto* follower = dynamic_cast<ScanFollower*>(plugin.get());
    if (follower != nullptr) follower->expect(robot_, keyframe.odometry.has_value());
  }
  return ask([&](std::size_t p) {
    return seeing.empty() || seeing[p] ? plugins_[p]->observe(frame, map) : Contribution();
  });
}

StepRecord Mapper::record(const Keyframe& keyframe, const BackendReport& report) const {
  return {report,        static_cast<int>(steps_.size()) - 1,
          keyframe.time, plugin_ms_,
          report.cost,   landmarks_.size(),
          robot_,        !keyframe.detections.empty()};
}

FixSource* Mapper::fix_source() const {
  return fix_source_of(plugins_);
}

BackendReport Mapper::finish() {
  look_for_datum(true);
  BackendReport work = revise(true);
  add_work(work, solve(&Backend::finish));
  return work;
}

}  // namespace hybrid
