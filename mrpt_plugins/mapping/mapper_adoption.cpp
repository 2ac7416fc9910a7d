// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Known landmarks and a known start.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/discrete/probabilities.h"
#include "libhybrid/hybrid/semantic.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/mapping/fix_source.h"
#include "mrpt_plugins/mapping/mapper.h"

namespace hybrid {
namespace {

constexpr double kLeastProbability = 1e-12;  // of a class; keeps every class possible
constexpr double kForgotten = 1e6;           // factor of the covariance of a forgotten start

std::vector<double> positive(std::vector<double> p) {
  double sum = 0;
  for (double& v : p) sum += (v = std::max(v, kLeastProbability));
  for (double& v : p) v /= sum;
  return p;
}

}  // namespace

void Mapper::adopt(const KnownMap& known) {
  for (const auto& plugin : plugins_) plugin->adopt(known, is_3d_);
  if (!known.landmarks.empty() && class_names() != known.class_names) {
    throw Error(fmt::format("the classes of the map are '{}', those of the settings '{}'",
                            fmt::join(known.class_names, " "), fmt::join(class_names(), " ")));
  }
  Delta delta;
  delta.continuous = known.prior;
  for (const KnownLandmark& landmark : known.landmarks) {
    Landmark entry{landmark.id, position_key(landmark.id), std::nullopt, landmark.sightings};
    insert_point(delta.values, entry.position, landmark.position, is_3d_);
    const std::vector<double>& p = landmark.class_probabilities;
    if (!p.empty()) {
      entry.class_key = DiscreteKey{Key(key_letter::kLandmarkClass, entry.position.index()),
                                    static_cast<int>(p.size())};
      delta.discrete.push_back(prior_table(*entry.class_key, positive(p)));
      delta.assignment.set(entry.class_key->key, most_probable(p));
    }
    landmarks_.add(entry);
  }
  if (!known.landmarks.empty()) count(backend_->update(delta));
  landmarks_.commit();
}

void Mapper::adopt(const MapDatum& datum) {
  if (FixSource* source = fix_source()) source->adopt(datum);
}

/// Notes where the prior of the first pose of a robot is, for forget_start().
void Mapper::note_start(const Delta& motion, const BackendReport& report) {
  const bool first = robot().poses.empty() && !motion.continuous.empty();
  const bool is_known = robot().options.motion.start.has_value();
  const bool may_move = !is_known && fix_source() != nullptr;
  if (!first || !(is_known || may_move) || robot().start) return;
  robot().start = report.handles.continuous.front();
  if (may_move || robot().options.motion.start->found) backend_->hold(pose_key(steps_.size()));
}

/// Once the axes of a datum are those of the map, its first poses are where the fixes say: all that
/// is known of them besides is that they are about level.
void Mapper::look_for_datum(bool is_last) {
  if (!may_find_datum_) return;
  FixSource* source = fix_source();
  const bool is_known = robots_.front().options.motion.start.has_value();
  may_find_datum_ = source != nullptr && !source->datum() && !is_known;
  if (!may_find_datum_ || !source->find_datum(view(), is_last && !has_motion_)) return;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Robot& robot = robots_[i];
    KnownStart wide;
    if (robot.poses.empty()) continue;
    wide.T_map_robot = to_isometry(pose_at(backend_->values(), pose_key(robot.poses.front())));
    constexpr double kFar = 1e3, kTurned = 3, kTilted = 0.2;  // m, rad, rad
    Eigen::VectorXd sigmas(is_3d_ ? 6 : 3);
    if (is_3d_) {
      sigmas << kFar, kFar, kFar, kTilted, kTilted, kTurned;
    } else {
      sigmas << kFar, kFar, kTurned;
    }
    wide.covariance = sigmas.array().square().matrix().asDiagonal();
    set_start(robot, wide);
  }
}

/// Replaces what is known of the first pose of a robot, if that can still be taken back.
void Mapper::set_start(Robot& robot, const KnownStart& start) {
  if (!robot.start || !backend_->graph().contains(*robot.start)) return;
  Delta delta;
  delta.remove.push_back(*robot.start);
  MotionOptions wide = robot.options.motion;
  wide.start = start;
  delta.continuous.push_back(origin_factor(pose_key(robot.poses.front()), wide, is_3d_));
  robot.start.reset();
  count(backend_->update(delta));
  backend_->release(pose_key(robot.poses.front()));
}

void Mapper::forget_start(std::size_t number) {
  Robot& robot = robots_[number];
  if (!robot.options.motion.start) return;
  KnownStart wide = *robot.options.motion.start;
  wide.covariance *= kForgotten;
  set_start(robot, wide);
}

std::map<std::int64_t, double> Mapper::existence() const {
  std::map<std::int64_t, double> all;
  for (const auto& plugin : plugins_) all.merge(plugin->existence());
  return all;
}

}  // namespace hybrid
