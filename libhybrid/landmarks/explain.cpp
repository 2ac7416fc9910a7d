// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/explain.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/detections/sighting.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostCandidates = 5;  // of one detection: a budget of the record

std::optional<std::int64_t> known(int track) {
  return track < 0 ? std::nullopt : std::make_optional<std::int64_t>(track);
}

SightingEvent event_of(int number, const LandmarkTracks& landmarks) {
  const Sighting& sighting = landmarks.sighting(number);
  SightingEvent event;
  event.number = number;
  event.pose = sighting.pose;
  event.sensor = sighting.sensor;
  event.detection = landmarks.detection_of(number, sighting.track);
  event.landmark = known(sighting.track);
  event.class_likelihood = sighting.phi;
  return event;
}

/// The most probable candidates for detection i of those that were matched.
std::vector<SightingCandidate> candidates_for(Eigen::Index i, const FrameCandidates& c,
                                              double unmatched_class_cost) {
  std::vector<SightingCandidate> all;
  for (std::size_t t = 0; t < c.tracks.size(); ++t) {
    const auto j = static_cast<Eigen::Index>(t);
    SightingCandidate candidate;
    candidate.landmark = c.tracks[t];
    candidate.nis = c.score(static_cast<std::size_t>(i), t).chi_square;
    candidate.class_log_odds = unmatched_class_cost - c.class_cost(i, j);
    candidate.log_odds = c.problem.unmatched[i] - c.problem.matched(i, j);
    all.push_back(candidate);
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.log_odds != b.log_odds ? a.log_odds > b.log_odds : a.nis < b.nis;
  });
  if (all.size() > kMostCandidates) all.resize(kMostCandidates);
  return all;
}

template <class Pose>
GaussianScore score_of(const Pose& pose, const Pose& sensor, Key landmark,
                       const MeasuredPoint& measured, const KeyframeView& frame,
                       const MapView& map) {
  const auto predicted =
      predict_sightings<Pose>(pose, sensor, {map.values.at<typename Pose::Point>(landmark)},
                              frame.joint_covariance({landmark}));
  return predicted.score(measured, 0);
}

}  // namespace

void explain_frame(const LandmarkTracks& landmarks, const std::vector<int>& noted,
                   const FrameMatching& matching, const ClassModel& classes, LandmarkEvents& out) {
  const std::vector<int>& matched = matching.sightings;
  if (classes.names().size() > 1) out.class_prior = classes.prior();
  const std::vector<double> prior =
      classes.names().empty() ? std::vector<double>{} : classes.prior();
  for (const int s : noted) {
    SightingEvent event = event_of(s, landmarks);
    const auto row = std::find(matched.begin(), matched.end(), s);
    if (row != matched.end()) {
      event.candidates = candidates_for(row - matched.begin(), matching.candidates,
                                        class_cost(landmarks.sighting(s).phi, prior));
    }
    for (const SightingCandidate& candidate : event.candidates) {
      if (event.landmark == candidate.landmark) event.nis = candidate.nis;
    }
    out.sightings.push_back(std::move(event));
  }
  if (matched.empty()) return;
  AssociationEvent event;
  event.pose = landmarks.sighting(matched.front()).pose;
  event.sightings.assign(matched.begin(), matched.end());
  event.open = matching.open;
  for (const FrameHypothesis& hypothesis : matching.hypotheses) {
    event.hypotheses.push_back({{}, matching.hypotheses.front().cost - hypothesis.cost});
    for (const int t : hypothesis.track) event.hypotheses.back().landmarks.push_back(known(t));
  }
  out.associations.push_back(std::move(event));
}

SightingEvent identified_sighting(const KeyframeView& frame, const DetectionFrame& seen,
                                  const Detection& detection, std::int64_t id, const MapView& map) {
  SightingEvent event;
  event.pose = frame.pose;
  auto sensor = std::make_shared<DetectionFrame>(seen);
  sensor->detections.clear();
  event.sensor = std::move(sensor);
  event.detection = detection;
  event.landmark = id;
  const Landmark* landmark = map.landmarks.find(id);
  if (landmark == nullptr || !map.holds || !map.holds(landmark->position)) return event;
  const MeasuredPoint measured = measured_point(detection, map.is_3d);
  try {
    if (map.is_3d) {
      event.nis = score_of(to_se3(frame.T_map_robot), to_se3(seen.T_robot_sensor),
                           landmark->position, measured, frame, map)
                      .chi_square;
    } else {
      event.nis = score_of(to_se2(frame.T_map_robot), to_se2(seen.T_robot_sensor),
                           landmark->position, measured, frame, map)
                      .chi_square;
    }
  } catch (const SettingsError&) {  // a batch solver has no covariance on the way
  }
  return event;
}

std::vector<AssociationDecision> decisions(const MapView& map, const OpenMatchings& open,
                                           const MovingThings& movers,
                                           const LandmarkTracks& landmarks) {
  const std::map<int, int> undecided = open.tracks(map);
  std::vector<AssociationDecision> out;
  for (int s = 0; s < static_cast<int>(landmarks.sightings().size()); ++s) {
    const Sighting& sighting = landmarks.sighting(s);
    if (sighting.frame == 0) continue;  // of a landmark known before
    const auto it = undecided.find(s);
    const int t = it == undecided.end() ? sighting.track : it->second;
    AssociationDecision decision{std::nullopt, sighting.detection.true_id};
    if (t >= 0 && landmarks.track(t).alive) decision.estimated_id = t;
    decision.mover = movers.mover_of(s);
    if (sighting.detection.members.empty()) out.push_back(decision);
    for (const auto& true_id : sighting.detection.members) {
      decision.true_id = true_id;
      out.push_back(decision);
    }
  }
  return out;
}

}  // namespace hybrid
