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

/// Notes where the prior of the first pose of a robot is, for forget_start().
void Mapper::note_start(const Delta& motion, const BackendReport& report) {
  const bool first = robot().poses.empty() && !motion.continuous.empty();
  if (!first || !robot().options.motion.start || robot().start) return;
  robot().start = report.handles.continuous.front();
  if (robot().options.motion.start->found) backend_->hold(pose_key(steps_.size()));
}

void Mapper::forget_start(std::size_t number) {
  Robot& robot = robots_[number];
  if (!robot.start || !backend_->graph().contains(*robot.start)) return;
  Delta delta;
  delta.remove.push_back(*robot.start);
  MotionOptions wide = robot.options.motion;
  wide.start->covariance *= kForgotten;
  delta.continuous.push_back(origin_factor(pose_key(robot.poses.front()), wide, is_3d_));
  robot.start.reset();
  count(backend_->update(delta));
  backend_->release(pose_key(robot.poses.front()));
}

std::map<std::int64_t, double> Mapper::existence() const {
  std::map<std::int64_t, double> all;
  for (const auto& plugin : plugins_) all.merge(plugin->existence());
  return all;
}

}  // namespace hybrid
