// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// The result of a mapper.

#include <algorithm>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/discrete/probabilities.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/mapping/fix_source.h"
#include "mrpt_plugins/mapping/mapper.h"

namespace hybrid {
namespace {

/// A 2x2 or 3x3 covariance of a point as 3x3.
Eigen::Matrix3d padded(const Eigen::MatrixXd& covariance) {
  Eigen::Matrix3d out = Eigen::Matrix3d::Zero();
  out.topLeftCorner(covariance.rows(), covariance.cols()) = covariance;
  return out;
}

}  // namespace

std::vector<AssociationDecision> Mapper::decisions() const {
  std::vector<AssociationDecision> all;
  for (const auto& plugin : plugins_) {
    for (const AssociationDecision& decision : plugin->decisions(view())) all.push_back(decision);
  }
  return all;
}

std::map<std::string, double> Mapper::statistics() const {
  std::map<std::string, double> all = {
      {"updates", static_cast<double>(updates_)},
      {"updates_by_local_search", static_cast<double>(updates_by_local_search_)}};
  if (robots_.size() > 1) all["robot_sightings"] = static_cast<double>(sightings_.used());
  for (const auto& plugin : plugins_) all.merge(plugin->statistics());
  all.merge(backend_->statistics());
  return all;
}

std::map<std::string, std::size_t> Mapper::dropped() const {
  std::map<std::string, std::size_t> all = dropped_;
  all.merge(sightings_.dropped());
  return all;
}

std::vector<std::string> Mapper::class_names() const {
  for (const auto& plugin : plugins_) {
    if (!plugin->class_names().empty()) return plugin->class_names();
  }
  return {};
}

std::vector<std::string> Mapper::robot_names() const {
  std::vector<std::string> names;
  for (const Robot& robot : robots_) names.push_back(robot.options.name);
  if (names.front().empty()) names.clear();
  return names;
}

MapResult Mapper::result() const {
  MapResult result = result_without_sizes();
  std::map<std::int64_t, LandmarkSize> sizes;
  for (const auto& plugin : plugins_) sizes.merge(plugin->sizes(view()));
  for (LandmarkEstimate& landmark : result.landmarks) {
    const auto size = sizes.find(landmark.id);
    if (size != sizes.end()) landmark.size = size->second;
  }
  return result;
}

Trajectory Mapper::trajectory() const {
  Trajectory out;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    out.push_back({steps_[i].time, pose_at(backend_->values(), pose_key(i))});
  }
  return out;
}

MapResult Mapper::result_without_sizes() const {
  MapResult result;
  result.is_3d = is_3d_;
  result.has_odometry = has_motion_;
  result.in_known_map = robots_.front().options.motion.start.has_value();
  if (!robots_.front().options.name.empty()) {
    for (const Robot& robot : robots_) result.robots.push_back({robot.options.name, robot.poses});
  }
  result.class_names = class_names();
  result.dead_reckoning = dead_reckoning_;
  result.steps = steps_;
  add_modes(result);
  add_movers(result);
  add_fixes(result);
  for (const Robot& robot : robots_) {
    for (CalibrationEstimate& estimate : robot.calibrator.estimates(*backend_)) {
      result.calibration.push_back(std::move(estimate));
    }
  }
  const Values& values = backend_->values();
  result.trajectory = trajectory();
  std::vector<Key> points;
  std::vector<DiscreteKey> classes;
  for (const auto& [id, landmark] : landmarks_) {
    points.push_back(landmark.position);
    if (landmark.class_key) classes.push_back(*landmark.class_key);
  }
  const Uncertainty uncertainty = backend_->uncertainty(points, classes);
  for (const auto& [id, landmark] : landmarks_) {
    LandmarkEstimate out;
    out.id = id;
    out.position = point_at(values, landmark.position);
    out.is_3d = is_3d_;
    out.sightings = landmark.sightings;
    const auto covariance = uncertainty.covariances.find(landmark.position);
    if (covariance != uncertainty.covariances.end()) out.covariance = padded(covariance->second);
    if (landmark.class_key) {
      out.class_index = backend_->assignment().at(landmark.class_key->key);
      const auto p = uncertainty.probabilities.find(landmark.class_key->key);
      if (p != uncertainty.probabilities.end()) out.class_probabilities = p->second;
    }
    result.landmarks.push_back(std::move(out));
  }
  return result;
}

/// The movers that all plugins follow, each with a number of its own.
void Mapper::add_movers(MapResult& result) const {
  std::vector<std::pair<double, std::size_t>> keyframes;
  for (std::size_t i = 0; i < steps_.size(); ++i) keyframes.emplace_back(steps_[i].time, i);
  std::sort(keyframes.begin(), keyframes.end());
  std::vector<double> times;
  for (const auto& [time, i] : keyframes) times.push_back(time);
  times.erase(std::unique(times.begin(), times.end()), times.end());
  for (const auto& plugin : plugins_) {
    for (Mover& mover : plugin->movers(times, view())) {
      MoverEstimate out{std::move(mover), {}, std::nullopt};
      for (const MoverState& state : out.states) {
        const auto at = std::lower_bound(keyframes.begin(), keyframes.end(),
                                         std::make_pair(state.time, std::size_t{0}));
        out.keyframes.push_back(at->second);
      }
      const std::vector<double>& p = out.class_probabilities;
      if (p.size() == result.class_names.size() && !p.empty()) {
        out.class_index = most_probable(p);
      }
      result.movers.push_back(std::move(out));
    }
  }
}

/// Fixes with the probabilities of their modes.
void Mapper::add_fixes(MapResult& result) const {
  const FixSource* source = fix_source();
  if (source == nullptr) return;
  const std::vector<FixEntry>& fixes = source->fix_mapper().fixes();
  const Uncertainty uncertainty = backend_->uncertainty({}, discrete_keys_of(fixes));
  result.datum = source->datum();
  const FixEstimator estimate(result.datum, backend_->values(), backend_->assignment(),
                              uncertainty);
  for (const FixEntry& entry : fixes) result.fixes.push_back(estimate(entry));
}

void Mapper::add_modes(MapResult& result) const {
  const std::vector<MotionMode>& modes = robots_.front().options.motion.modes;
  if (modes.empty()) return;
  std::vector<DiscreteKey> keys;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const DiscreteKey key{Key(key_letter::kMotionMode, i), static_cast<int>(modes.size())};
    const int mode = backend_->assignment().find(key.key);
    result.motion_modes.push_back(mode);
    if (mode >= 0) keys.push_back(key);
  }
  for (const MotionMode& mode : modes) result.mode_names.push_back(mode.name);
  Uncertainty uncertainty = backend_->uncertainty({}, keys);
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    result.mode_probabilities.push_back(
        std::move(uncertainty.probabilities[Key(key_letter::kMotionMode, i)]));
  }
}

std::vector<Eigen::MatrixXd> Mapper::pose_covariances() const {
  std::vector<Key> keys;
  for (std::size_t i = 0; i < steps_.size(); ++i) keys.push_back(pose_key(i));
  Uncertainty uncertainty = backend_->uncertainty(keys, {});
  std::vector<Eigen::MatrixXd> out(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto it = uncertainty.covariances.find(keys[i]);
    if (it != uncertainty.covariances.end()) out[i] = std::move(it->second);
  }
  return out;
}

}  // namespace hybrid
