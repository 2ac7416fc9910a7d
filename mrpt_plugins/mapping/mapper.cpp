// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/mapper.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/motion_covariance.h"
#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

/// Reserves memory, so that the next push_back cannot throw.
template <class T>
void make_room(std::vector<T>& list) {
  if (list.size() == list.capacity()) list.reserve(2 * list.size() + 1);
}

}  // namespace

Mapper::Mapper(const MotionOptions& options, std::vector<std::shared_ptr<MappingPlugin>> plugins,
               std::unique_ptr<Backend> backend, bool is_3d, const CalibrationOptions& calibration)
    : options_(options),
      plugins_(std::move(plugins)),
      backend_(std::move(backend)),
      is_3d_(is_3d),
      calibrator_(calibration, is_3d) {
  check(options_, is_3d_);
}

const StepRecord& Mapper::add(const Keyframe& raw) {
  Keyframe keyframe = raw;
  make_room(steps_);
  make_room(log_rows_);
  make_room(dead_reckoning_);
  plugin_ms_ = 0;
  row_ = raw.row;
  Motion motion = predict(keyframe);
  calibrator_.place_sensors(keyframe.detections, backend_->values(), motion.delta);
  const std::vector<Contribution> contributions = observe(keyframe, motion);
  BackendReport report;
  try {
    report = update(motion.delta, contributions);
  } catch (const Error& e) {
    if (!keyframe.odometry) throw Error(fmt::format("step {} of the log: {}", row_, e.what()));
    note("odometry dropped: not usable", e.what());
    motion = predict_from(nullptr);
    report = update(motion.delta, {});
  }
  last_mode_ = motion.mode;
  dead_reckoning_.push_back({keyframe.time, motion.T_odometry_robot});
  log_rows_.push_back(keyframe.row);
  steps_.push_back({});
  T_map_robot_ = pose_at(backend_->values(), pose_key(steps_.size() - 1));
  add_work(report, revise(false));
  T_map_robot_ = pose_at(backend_->values(), pose_key(steps_.size() - 1));
  steps_.back() = record(keyframe, report);
  return steps_.back();
}

/// The motion to a new pose. Unusable odometry is dropped.
Mapper::Motion Mapper::predict(Keyframe& keyframe) {
  if (!steps_.empty() && !keyframe.odometry) {
    ++dropped_["odometry missing: robot taken to stand still"];
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
  const std::size_t i = steps_.size();
  if (i == 0) {
    out.factor = origin_factor(pose_key(0), options_, is_3d_);
    out.delta.continuous.push_back(out.factor);
    if (options_.start) {
      out.T_map_robot = to_mrpt(options_.start->T_map_robot);
      out.T_odometry_robot = out.T_map_robot;
    }
  } else {
    const OdometryIncrement motion =
        measured != nullptr ? *measured : unknown_motion(options_, is_3d_);
    out.factor = odometry_factor(pose_key(i - 1), pose_key(i), motion, options_, is_3d_);
    add_motion(i, motion, measured != nullptr, out);
    out.T_map_robot = T_map_robot_ + calibrator_.corrected(motion.mean, backend_->values());
    out.T_odometry_robot = dead_reckoning_.back().pose + motion.mean;
  }
  insert_pose(out.delta.values, pose_key(i), out.T_map_robot, is_3d_);
  return out;
}

/// Adds the factors of the motion to pose i. Missing odometry has no mode and no calibration.
void Mapper::add_motion(std::size_t i, const OdometryIncrement& motion, bool measured,
                        Motion& out) const {
  const Key from = pose_key(i - 1), to = pose_key(i);
  Delta& delta = out.delta;
  const std::optional<Key> calibration =
      measured ? calibrator_.odometry(backend_->values(), delta) : std::nullopt;
  if (options_.modes.empty() || !measured) {
    delta.continuous.push_back(odometry_factor(from, to, motion, options_, is_3d_, calibration));
  } else {
    const DiscreteKey mode{Key(key_letter::kMotionMode, i),
                           static_cast<int>(options_.modes.size())};
    delta.hybrid.push_back(switching_factor(mode, from, to, motion, options_, is_3d_, calibration));
    delta.discrete.push_back(last_mode_ ? chain_step(options_.chain, *last_mode_, mode)
                                        : chain_tables(options_.chain, {mode}).front());
    out.mode = mode;
  }
  if (options_.steady_sigma_m > 0 && i >= 2) {
    delta.continuous.push_back(steady_factor(pose_key(i - 2), from, to, options_, is_3d_));
  }
}

MapView Mapper::view() const {
  MapView view{backend_->values(), backend_->assignment(), landmarks_, is_3d_};
  view.keeps_all = backend_->keeps_all();
  view.explain = events_.has_value();
  view.holds = [this](Key key) { return backend_->holds(key); };
  view.joint_covariance = [this](const std::vector<Key>& keys) {
    return backend_->joint_covariance(keys);
  };
  return view;
}

/// Calls observe() of each plugin; a plugin that throws contributes nothing.
std::vector<Contribution> Mapper::observe(const Keyframe& keyframe, const Motion& motion) {
  const Frame frame{pose_key(steps_.size()), motion.T_map_robot, keyframe.detections,
                    keyframe.observations};
  MapView map = view();
  map.joint_covariance = [&](const std::vector<Key>& keys) {
    return covariance_after_motion(
        *motion.factor, motion.delta.values, backend_->values(),
        [this](const std::vector<Key>& held) { return backend_->joint_covariance(held); }, keys);
  };
  return ask([&](MappingPlugin& plugin) { return plugin.observe(frame, map); });
}

StepRecord Mapper::record(const Keyframe& keyframe, const BackendReport& report) const {
  return {report,        static_cast<int>(steps_.size()) - 1,
          keyframe.time, plugin_ms_,
          report.cost,   landmarks_.size()};
}

BackendReport Mapper::finish() {
  BackendReport work = revise(true);
  add_work(work, solve());
  return work;
}

}  // namespace hybrid
