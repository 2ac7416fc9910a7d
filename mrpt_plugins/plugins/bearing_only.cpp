// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/detail/bearing_only.h"

#include <cmath>
#include <memory>
#include <utility>

#include "libhybrid/association/association_factor.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/semantic.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/mapping/register_plugin.h"
#include "mrpt_plugins/plugins/detail/refuse_numbered.h"
#include "mrpt_plugins/plugins/read_landmark_options.h"

HYBRID_REGISTER_PLUGIN(BearingOnlyKnownIds, hybrid)

namespace hybrid {
namespace {

ContinuousFactorPtr prior_of_position(const PlacedLandmark& landmark) {
  const Key key = position_key(landmark.id);
  const Eigen::VectorXd& at = landmark.point;
  if (at.size() == 3) {
    return std::make_shared<Prior<Eigen::Vector3d>>(key, Eigen::Vector3d(at),
                                                    Noise::isotropic(3, kAnywhere));
  }
  return std::make_shared<Prior<Eigen::Vector2d>>(key, Eigen::Vector2d(at),
                                                  Noise::isotropic(2, kAnywhere));
}

}  // namespace

void BearingOnlyKnownIds::configure(IniSection section) {
  sensors_ = read_sensors(section);
  section.read("least_depth", least_depth_, "of a landmark at first sight [m]", kPositiveLength);
  section.read("greatest_depth", greatest_depth_, "of a landmark at first sight [m]",
               kPositiveLength);
  if (greatest_depth_ <= least_depth_) section.fail("greatest_depth", "is below least_depth");
  section.read("depths", depths_, "tried between them", {2, 1000});
  bank_ = read_bank_options(section);
  classes_ = read_class_model(section);
}

Contribution BearingOnlyKnownIds::observe(const Frame& frame, const MapView& map) {
  Contribution out;
  placed_.begin();
  for (const DetectionFrame& seen : frame.detections) {
    if (!is_wanted(seen.sensor_label, sensors_)) continue;
    if (seen.has_range || seen.detections.empty()) continue;
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
  for (const PlacedLandmark& landmark : unplaced_.place(frame.view(), map, bank_)) {
    place(landmark, map, out);
  }
  return out;
}

Contribution BearingOnlyKnownIds::conclude(const MapView&) {
  Contribution out;
  placed_.begin();
  if (std::exchange(concluded_, true)) return out;
  for (const auto& [why, count] : unplaced_.unplaced(bank_)) {
    out.dropped["detection not used: its landmark has no place, since " + why] += count;
  }
  return out;
}

void BearingOnlyKnownIds::take(const DetectionFrame& seen, const Detection& detection,
                               const Frame& frame, const MapView& map, Contribution& out) {
  const std::int64_t id = *detection.id;
  const Key point = position_key(id);
  GaussianSumInitializer::Measurement measurement;
  measurement.outlier_density = map.is_3d ? 1 / (4 * M_PI) : 1 / (2 * M_PI);
  measurement.real = bearing_factor(frame.pose, point, seen, detection, map.is_3d);
  if (!detection.class_probabilities.empty()) {
    measurement.class_likelihood =
        classes_.likelihood(detection.class_probabilities, seen.class_names);
  }
  // The drift changes a direction by drift / depth; use the geometric mean of the depths.
  const double depth = std::sqrt(least_depth_ * greatest_depth_);
  measurement.trial =
      bearing_factor(frame.pose, point, seen, detection, map.is_3d, bank_.drift / depth);
  if (map.landmarks.find(id) != nullptr) {
    add_sighting(id, measurement, out);
    return;
  }
  unplaced_.add(id, std::move(measurement), bank_, [&] {
    Detection unit = detection;
    unit.range = 1;
    const Eigen::Isometry3d T_map_robot = to_isometry(frame.T_map_robot);
    const Eigen::Vector3d from = compose(T_map_robot, seen.T_robot_sensor).translation();
    const Eigen::Vector3d ray = sighted_point(T_map_robot, seen, unit) - from;
    const Eigen::Index n = map.is_3d ? 3 : 2;
    return ray_places(from.head(n), ray.head(n), least_depth_, greatest_depth_, depths_);
  });
  for (Measurement& old : placed_.restart(id)) {
    unplaced_.add(id, std::move(old), bank_, [] { return std::vector<Eigen::VectorXd>(); });
  }
}

DiscreteKey BearingOnlyKnownIds::class_key(std::int64_t id) const {
  return {Key(key_letter::kLandmarkClass, position_key(id).index()),
          static_cast<int>(classes_.names().size())};
}

void BearingOnlyKnownIds::add_sighting(std::int64_t id, const Measurement& measurement,
                                       Contribution& out) {
  out.sighted.push_back(id);
  AssociationOption right{measurement.real, -std::log1p(-bank_.outlier_share), std::nullopt};
  const AssociationOption wrong{
      nullptr, -std::log(bank_.outlier_share * measurement.outlier_density), std::nullopt};
  if (!measurement.class_likelihood.empty()) {
    right.classes = likelihood_table(class_key(id), measurement.class_likelihood);
  }
  const DiscreteKey choice{Key(key_letter::kBearingChoice, choices_++), 2};
  out.delta.hybrid.push_back(
      std::make_shared<AssociationFactor>(choice, std::vector<AssociationOption>{right, wrong}));
  placed_.measure(id, measurement, choice.key, out.delta.hybrid.size() - 1);
}

void BearingOnlyKnownIds::applied(const Outcome& outcome) {
  placed_.applied(outcome.handles);
}

void BearingOnlyKnownIds::adopt(const KnownMap& known, bool) {
  refuse_numbered(known);
}

void BearingOnlyKnownIds::refused() {
  placed_.refused();
}

Contribution BearingOnlyKnownIds::revise(const MapView& map) {
  placed_.begin();
  return placed_.take_out(map, bank_);
}

void BearingOnlyKnownIds::place(const PlacedLandmark& landmark, const MapView& map,
                                Contribution& out) {
  insert_point(out.delta.values, position_key(landmark.id), padded_point(landmark.point),
               map.is_3d);
  PlacedLandmarks::Priors priors;
  Landmark entry{landmark.id, position_key(landmark.id), std::nullopt, 0};
  if (!classes_.names().empty()) {
    entry.class_key = class_key(landmark.id);
    out.delta.discrete.push_back(prior_table(*entry.class_key, classes_.prior()));
    priors.of_class = out.delta.discrete.size() - 1;
  }
  // Directions that agree with any distance, as of what the robot drives at, leave it there.
  out.delta.continuous.push_back(prior_of_position(landmark));
  priors.of_position = out.delta.continuous.size() - 1;
  placed_.place(landmark, priors);
  out.landmarks.push_back(entry);
  for (const auto& measurement : landmark.measurements) {
    add_sighting(landmark.id, measurement, out);
  }
}

}  // namespace hybrid
