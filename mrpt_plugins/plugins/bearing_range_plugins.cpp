// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/detail/bearing_range_plugins.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/discrete/probabilities.h"
#include "libhybrid/hybrid/semantic.h"
#include "libhybrid/landmarks/explain.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/mapping/register_plugin.h"
#include "mrpt_plugins/plugins/detail/refuse_numbered.h"
#include "mrpt_plugins/plugins/read_landmark_options.h"

HYBRID_REGISTER_PLUGIN(BearingRangeKnownIds, hybrid)
HYBRID_REGISTER_PLUGIN(ClassedBearingRangeKnownIds, hybrid)

namespace hybrid {
namespace {

/// Calls use(frame, detection, id) for each detection of these sensors that has an id and fits the
/// map; counts the others as dropped.
template <class Use>
void for_each_identified(const Frame& frame, const MapView& map,
                         const std::vector<std::string>& sensors, Contribution& out, Use&& use) {
  for (const DetectionFrame& seen : frame.detections) {
    if (!is_wanted(seen.sensor_label, sensors) || seen.detections.empty()) continue;
    const std::string reason = misfit(seen, map.is_3d);
    if (!reason.empty()) {
      out.dropped["detection dropped: " + reason] += seen.detections.size();
      continue;
    }
    for (const Detection& detection : seen.detections) {
      if (detection.id) {
        if (map.explain) {
          out.events.sightings.push_back(
              identified_sighting(frame.view(), seen, detection, *detection.id, map));
        }
        use(seen, detection, *detection.id);
      } else {
        ++out.dropped["detection dropped: no landmark id"];
      }
    }
  }
}

bool is_new(std::int64_t id, const MapView& map, const Contribution& out) {
  const auto same = [id](const Landmark& landmark) { return landmark.id == id; };
  return map.landmarks.find(id) == nullptr &&
         std::none_of(out.landmarks.begin(), out.landmarks.end(), same);
}

/// Adds the position of a new landmark, as the detection measures it.
void add_position(std::int64_t id, const Frame& frame, const DetectionFrame& seen,
                  const Detection& detection, bool is_3d, Delta& delta) {
  insert_point(delta.values, position_key(id),
               sighted_point(frame.view().T_map_robot, seen, detection), is_3d);
}

int first_class(std::vector<double> prior, const std::vector<double>& likelihood) {
  for (std::size_t s = 0; s < prior.size(); ++s) prior[s] *= likelihood[s];
  return most_probable(prior);
}

}  // namespace

void IdReading::configure(IniSection& section) {
  sensors = read_sensors(section);
  section.read("huber_width", huber_width,
               "for ids that are sometimes misread: beyond so many sigmas the cost of a sighting "
               "grows only linearly; 0: none is wrong",
               or_zero({1e-3, 1e3}));
}

void BearingRangeKnownIds::adopt(const KnownMap& known, bool) {
  refuse_numbered(known);
}

void BearingRangeKnownIds::configure(IniSection section) {
  ids_.configure(section);
}

Contribution BearingRangeKnownIds::observe(const Frame& frame, const MapView& map) {
  Contribution out;
  const Loss loss = ids_.loss();
  for_each_identified(frame, map, ids_.sensors, out,
                      [&](const DetectionFrame& seen, const Detection& detection, std::int64_t id) {
                        if (is_new(id, map, out)) {
                          out.landmarks.push_back({id, position_key(id), std::nullopt, 0});
                          add_position(id, frame, seen, detection, map.is_3d, out.delta);
                        }
                        out.sighted.push_back(id);
                        out.delta.continuous.push_back(sighting_factor(
                            frame.pose, position_key(id), seen, detection, map.is_3d, loss));
                      });
  return out;
}

void ClassedBearingRangeKnownIds::configure(IniSection section) {
  ids_.configure(section);
  classes_ = read_class_model(section);
}

void ClassedBearingRangeKnownIds::adopt(const KnownMap& known, bool) {
  refuse_numbered(known);
  if (!known.class_names.empty()) classes_.learn_names(known.class_names);
}

Contribution ClassedBearingRangeKnownIds::observe(const Frame& frame, const MapView& map) {
  Contribution out;
  const Loss loss = ids_.loss();
  for_each_identified(
      frame, map, ids_.sensors, out,
      [&](const DetectionFrame& seen, const Detection& detection, std::int64_t id) {
        classes_.learn_names(seen.class_names);
        const DiscreteKey class_key{Key(key_letter::kLandmarkClass, position_key(id).index()),
                                    static_cast<int>(classes_.names().size())};
        const std::vector<double> phi =
            classes_.likelihood(detection.class_probabilities, seen.class_names);
        if (map.explain) {
          out.events.class_prior = classes_.prior();
          out.events.sightings.back().class_likelihood = phi;
        }
        if (is_new(id, map, out)) {
          out.landmarks.push_back({id, position_key(id), class_key, 0});
          add_position(id, frame, seen, detection, map.is_3d, out.delta);
          out.delta.discrete.push_back(prior_table(class_key, classes_.prior()));
          out.delta.assignment.set(class_key.key, first_class(classes_.prior(), phi));
        }
        out.sighted.push_back(id);
        ContinuousFactorPtr psi =
            sighting_factor(frame.pose, position_key(id), seen, detection, map.is_3d, loss);
        if (detection.class_probabilities.empty()) {
          out.delta.continuous.push_back(std::move(psi));
        } else {
          out.delta.hybrid.push_back(
              std::make_shared<WeightedFactor>(std::move(psi), likelihood_table(class_key, phi)));
        }
      });
  return out;
}

}  // namespace hybrid
