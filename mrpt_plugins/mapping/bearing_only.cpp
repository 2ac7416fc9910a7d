// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/bearing_only.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "libhybrid/hybrid/semantic.h"
#include "mrpt_plugins/mapping/sighting.h"
#include "mrpt_plugins/mapping/space.h"

IMPLEMENTS_MRPT_OBJECT(BearingOnlyKnownIds, MappingPlugin, hybrid)

namespace hybrid {
namespace {

Key position_key(std::int64_t id) {
  return {'l', static_cast<std::uint64_t>(id)};
}

}  // namespace

void BearingOnlyKnownIds::configure(IniSection section) {
  sensors_ = section.get("sensors", sensors_, "labels of the sensors to use; empty: all");
  least_depth_ =
      section.get("least_depth", least_depth_, "of a landmark at first sight [m]", kPositive);
  greatest_depth_ =
      section.get("greatest_depth", greatest_depth_, "of a landmark at first sight [m]", kPositive);
  if (greatest_depth_ <= least_depth_) section.fail("greatest_depth", "is below least_depth");
  depths_ = section.get("depths", depths_, "tried between them", IniRange{2, 1000});
  bank_ = read_bank_options(section);
  classes_ = ClassModel(section);
}

Contribution BearingOnlyKnownIds::observe(const Frame& frame, const MapView& map) {
  Contribution out;
  for (const DetectionFrame& seen : frame.detections) {
    const bool wanted = sensors_.empty() || std::find(sensors_.begin(), sensors_.end(),
                                                      seen.sensor_label) != sensors_.end();
    if (!wanted || seen.has_range || seen.detections.empty()) continue;
    const std::string reason = misfit_of_bearing(seen, map.is_3d);
    if (!reason.empty()) {
      out.dropped["detection dropped: " + reason] += seen.detections.size();
      continue;
    }
    if (!seen.class_names.empty()) classes_.learn_names(seen.class_names);
    for (const Detection& detection : seen.detections) {
      if (detection.id) {
        take(seen, detection, frame, map, out);
      } else {
        ++out.dropped["detection dropped: no landmark id"];
      }
    }
  }
  for (const PlacedLandmark& landmark : unplaced_.place(frame, map, bank_)) {
    place(landmark, map, out);
  }
  return out;
}

void BearingOnlyKnownIds::take(const DetectionFrame& seen, const Detection& detection,
                               const Frame& frame, const MapView& map, Contribution& out) {
  const std::int64_t id = *detection.id;
  const Key point = position_key(id);
  HypothesisBank::Measurement measurement;
  measurement.real = bearing_factor(frame.pose, point, seen, detection, map.is_3d);
  if (!detection.class_probabilities.empty()) {
    measurement.class_likelihood =
        classes_.likelihood(detection.class_probabilities, seen.class_names);
  }
  if (map.landmarks.find(id) != nullptr) {
    add_sighting(id, measurement, out);
    return;
  }
  // What the drift does to a direction is least at the greatest depth; take a middle one.
  const double depth = std::sqrt(least_depth_ * greatest_depth_);
  measurement.trial =
      bearing_factor(frame.pose, point, seen, detection, map.is_3d, bank_.drift / depth);
  unplaced_.add(id, std::move(measurement), bank_, [&] {
    Detection unit = detection;
    unit.range = 1;
    const auto origin = (frame.T_map_robot + seen.T_robot_sensor).translation();
    const Eigen::Vector3d from(origin.x, origin.y, origin.z);
    const Eigen::Vector3d ray = sighted_point(frame.T_map_robot, seen, unit) - from;
    const Eigen::Index n = map.is_3d ? 3 : 2;
    return ray_places(from.head(n), ray.head(n), least_depth_, greatest_depth_, depths_);
  });
}

DiscreteKey BearingOnlyKnownIds::class_key(std::int64_t id) const {
  return {Key('s', position_key(id).index()), static_cast<int>(classes_.names().size())};
}

void BearingOnlyKnownIds::add_sighting(std::int64_t id,
                                       const HypothesisBank::Measurement& measurement,
                                       Contribution& out) {
  out.sighted.push_back(id);
  if (measurement.class_likelihood.empty()) {
    out.delta.continuous.push_back(measurement.real);
  } else {
    out.delta.hybrid.push_back(std::make_shared<WeightedFactor>(
        measurement.real, likelihood_table(class_key(id), measurement.class_likelihood)));
  }
}

void BearingOnlyKnownIds::place(const PlacedLandmark& landmark, const MapView& map,
                                Contribution& out) {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  point.head(landmark.point.size()) = landmark.point;
  insert_point(out.delta.values, position_key(landmark.id), point, map.is_3d);
  Landmark entry{landmark.id, position_key(landmark.id), std::nullopt, 0};
  if (!classes_.names().empty()) {
    entry.class_key = class_key(landmark.id);
    out.delta.discrete.push_back(prior_table(*entry.class_key, classes_.prior()));
  }
  out.landmarks.push_back(entry);
  for (const auto& measurement : landmark.measurements) {
    add_sighting(landmark.id, measurement, out);
  }
}

}  // namespace hybrid
