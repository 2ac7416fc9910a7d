// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/detail/bearing_only.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "libhybrid/association/association_factor.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/hybrid/semantic.h"
#include "libhybrid/landmarks/sighting.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/mapping/register_plugin.h"
#include "mrpt_plugins/plugins/read_landmark_options.h"

HYBRID_REGISTER_PLUGIN(BearingOnlyKnownIds, hybrid)

namespace hybrid {
void BearingOnlyKnownIds::configure(IniSection section) {
  sensors_ = section.get("sensors", sensors_, "labels of the sensors to use; empty: all");
  least_depth_ =
      section.get("least_depth", least_depth_, "of a landmark at first sight [m]", kPositiveLength);
  greatest_depth_ = section.get("greatest_depth", greatest_depth_,
                                "of a landmark at first sight [m]", kPositiveLength);
  if (greatest_depth_ <= least_depth_) section.fail("greatest_depth", "is below least_depth");
  depths_ = section.get("depths", depths_, "tried between them", IniRange{2, 1000});
  bank_ = read_bank_options(section);
  classes_ = read_class_model(section);
}

Contribution BearingOnlyKnownIds::observe(const Frame& frame, const MapView& map) {
  Contribution out;
  change_ = {};
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
  change_.placed = unplaced_.place(frame.view(), map, bank_);
  for (const PlacedLandmark& landmark : change_.placed) place(landmark, map, out);
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
  const auto restart = restarts_.find(id);
  if (restart == restarts_.end()) return;
  for (Measurement& old : restart->second)
    unplaced_.add(id, std::move(old), bank_, [] { return std::vector<Eigen::VectorXd>(); });
  restarts_.erase(restart);
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
  change_.sightings.push_back({id, {measurement, choice.key, {}}});
}

void BearingOnlyKnownIds::applied(const Outcome& outcome) {
  auto prior = outcome.handles.discrete.begin();
  auto factor = outcome.handles.hybrid.begin();
  if (!classes_.names().empty()) {
    for (const PlacedLandmark& landmark : change_.placed)
      placed_[landmark.id].class_prior = *prior++;
  }
  for (auto& [id, sighting] : change_.sightings) {
    sighting.factor = *factor++;
    placed_[id].sightings.push_back(std::move(sighting));
    touched_.insert(id);
  }
  change_ = {};
}

void BearingOnlyKnownIds::refused() {
  for (PlacedLandmark& landmark : change_.placed) {
    restarts_[landmark.id] = std::move(landmark.measurements);
  }
  for (auto& [id, landmark] : change_.taken_out) {
    restarts_.erase(id);
    placed_[id] = std::move(landmark);
  }
  change_ = {};
}

/// Whether more than half of the latest sightings, as many as an initialiser holds, are false.
bool BearingOnlyKnownIds::is_misplaced(const Placed& landmark, const Assignment& assignment) const {
  const auto count = std::min(landmark.sightings.size(), std::size_t(bank_.max_measurements));
  if (count < static_cast<std::size_t>(bank_.min_measurements)) return false;
  const auto wrong =
      std::count_if(landmark.sightings.end() - static_cast<std::ptrdiff_t>(count),
                    landmark.sightings.end(), [&](const Sighting& s) {
                      return assignment.contains(s.choice) && assignment.at(s.choice) == 1;
                    });
  return 2 * static_cast<std::size_t>(wrong) > count;
}

Contribution BearingOnlyKnownIds::revise(const MapView& map) {
  Contribution out;
  change_ = {};
  if (!map.keeps_all) {  // sightings outside the window are final
    placed_.clear();
    return out;
  }
  for (const std::int64_t id : touched_) {
    const auto it = placed_.find(id);
    if (it == placed_.end()) continue;
    const std::vector<Sighting>& own = it->second.sightings;
    if (!std::all_of(own.begin(), own.end(), [&](const Sighting& sighting) {
          return map.holds(sighting.measurement.real->keys().front());
        })) {
      placed_.erase(it);  // what has left the graph stays as it is
      continue;
    }
    if (!is_misplaced(it->second, map.assignment)) continue;
    std::vector<Measurement>& measurements = restarts_[id];
    for (const Sighting& sighting : it->second.sightings) {
      out.delta.remove.push_back(sighting.factor);
      measurements.push_back(sighting.measurement);
    }
    if (it->second.class_prior) out.delta.remove.push_back(*it->second.class_prior);
    out.delta.remove_values.push_back(position_key(id));
    out.forgotten.push_back(id);
    change_.taken_out[id] = std::move(it->second);
    placed_.erase(it);
  }
  touched_.clear();
  return out;
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
