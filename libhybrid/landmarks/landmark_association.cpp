// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/landmark_association.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/landmarks/count_things.h"
#include "libhybrid/landmarks/explain.h"

namespace hybrid {
namespace {

/// Landmarks whose place in the grid follows the estimate, each keyframe: a budget of time. Those
/// that are candidates of its detections do besides.
constexpr int kPlacedAtOnce = 40;
/// Numbers of landmarks that a map may have had, one after the other: some 300 bytes each are kept.
constexpr std::int64_t kMostIds = 1'000'000;
constexpr double kSureOdds = 12.0;  // log odds of existence above which they do not grow

}  // namespace

LandmarkAssociation::LandmarkAssociation(const AssociationOptions& options, ClassModel classes,
                                         std::vector<std::string> sensors)
    : sensors_(std::move(sensors)),
      options_(options),
      merging_(options),
      loops_(options),
      movers_(options) {
  if (options.extent.empty())
    throw Error("extent has no number: it needs one for all, or one for each class");
  now_.classes = std::move(classes);
}

void LandmarkAssociation::adopt(const KnownMap& known, bool is_3d) {
  for (const KnownLandmark& landmark : known.landmarks) {
    if (landmark.id >= 0 && landmark.id < kMostIds) continue;
    throw Error("landmark " + std::to_string(landmark.id) +
                " of the map has the id of a log, which numbers beyond 1,000,000 must be; use the "
                "plugin that made the map");
  }
  for (const KnownLandmark& landmark : known.landmarks) {
    std::vector<double>& extents = options_.extent;
    if (landmark.size.extent <= *std::max_element(extents.begin(), extents.end())) continue;
    extents = {landmark.size.extent};  // the map is used as it was made
    options_.method = AssociationOptions::Method::kJcbb;
  }
  if (!known.class_names.empty()) now_.classes.learn_names(known.class_names);
  landmarks_.adopt(known.landmarks, now_.classes, is_3d);
  adopted_ = !known.landmarks.empty();
}

std::map<std::int64_t, double> LandmarkAssociation::existence() const {
  std::map<std::int64_t, double> out;
  for (int t = 0; t < static_cast<int>(landmarks_.tracks().size()); ++t) {
    if (landmarks_.track(t).alive) out[t] = landmarks_.track(t).existence;
  }
  return out;
}

std::map<std::int64_t, LandmarkSize> LandmarkAssociation::sizes(const MapView& map) const {
  const std::vector<int> things =
      count_things(map, now_.classes, loops_.views(), options_, landmarks_);
  std::map<std::int64_t, LandmarkSize> out;
  for (int t = 0; t < static_cast<int>(things.size()); ++t) {
    const Track& track = landmarks_.track(t);
    if (track.alive) out[t] = {track.extent, std::max(things[t], track.known_things)};
  }
  return out;
}

Contribution LandmarkAssociation::observe(const KeyframeView& frame, const MapView& map) {
  Contribution out;
  merging_.forget(now_.keyframe);
  remember();
  ++now_.keyframe;
  follow_decisions(now_.open.decide_until(now_.keyframe - options_.window, map, landmarks_), map,
                   out);
  landmarks_.place_some(map.values, kPlacedAtOnce);
  for (const DetectionFrame& seen : frame.detections) {
    const bool wanted = sensors_.empty() || std::find(sensors_.begin(), sensors_.end(),
                                                      seen.sensor_label) != sensors_.end();
    if (!wanted) continue;
    const std::string reason = misfit(seen, map.is_3d);
    if (!reason.empty() && !seen.detections.empty()) {
      out.dropped["detection dropped: " + reason] += seen.detections.size();
      continue;
    }
    take(seen, frame, map, out);
  }
  return out;
}

/// Notes the detections of a frame, those that can be told apart. Returns their numbers.
std::vector<int> LandmarkAssociation::note(const DetectionFrame& seen, Key pose,
                                           const std::shared_ptr<const DetectionFrame>& sensor,
                                           bool is_3d, Contribution& out) {
  std::vector<int> noted;
  ++now_.frames;
  const std::vector<bool> crowded = are_crowded(seen);
  for (std::size_t i = 0; i < seen.detections.size(); ++i) {
    const Detection& detection = seen.detections[i];
    const bool named = options_.use_ids && detection.id.has_value();
    now_.sigmas += position_sigma(detection, is_3d);
    ++now_.detections;
    if (crowded[i] && !named) {
      ++out.dropped["detection dropped: too many others within its noise to be told apart"];
      continue;
    }
    Sighting sighting{now_.frames, pose, sensor, detection, {}, -1, {}};
    const std::vector<double>& scores = sighting.detection.class_probabilities;
    if (!scores.empty() && now_.classes.names().size() > 1) {
      sighting.phi = now_.classes.likelihood(scores, seen.class_names);
    }
    if (!named) sighting.extent = extent_of(sighting.phi);
    noted.push_back(landmarks_.note(std::move(sighting)));
  }
  return noted;
}

/// Of what is seen with this likelihood of each class: the root of the mean square over classes.
double LandmarkAssociation::extent_of(const std::vector<double>& phi) const {
  if (options_.extent.size() == 1) return options_.extent.front();
  std::vector<double> belief = now_.classes.prior();
  if (options_.extent.size() != belief.size()) {
    throw Error("extent has " + std::to_string(options_.extent.size()) + " numbers for " +
                std::to_string(belief.size()) + " classes: it needs one for all, or one for each");
  }
  double weights = 0, squares = 0;
  for (std::size_t s = 0; s < belief.size(); ++s) {
    if (!phi.empty()) belief[s] *= phi[s];
    weights += belief[s];
    squares += belief[s] * options_.extent[s] * options_.extent[s];
  }
  return std::sqrt(squares / weights);
}

void LandmarkAssociation::take(const DetectionFrame& seen, const KeyframeView& frame,
                               const MapView& map, Contribution& out) {
  SensorCoverage& coverage = now_.coverage[seen.sensor_label];
  coverage.learn(seen);
  if (coverage.max_range <= 0) return;
  now_.density = density_of_landmarks(now_.coverage, options_.landmarks_in_view);
  loops_.looked(frame, seen.T_robot_sensor, coverage, now_.density, map);
  if (!seen.class_names.empty()) now_.classes.learn_names(seen.class_names);
  auto sensor = std::make_shared<DetectionFrame>(seen);
  sensor->detections.clear();
  DetectionFrame unknown = *sensor;
  std::vector<int> sightings;
  std::vector<std::vector<double>> phi;
  const std::vector<int> noted = note(seen, frame.pose, sensor, map.is_3d, out);
  movers_.take(noted, frame, coverage, now_.classes, map, landmarks_);
  for (const int s : noted) {
    const Detection& detection = landmarks_.sighting(s).detection;
    if (!detection.may_be_landmark()) {
      ++out.dropped[MovingThings::kDropped];
      continue;
    }
    if (options_.use_ids && take_identified(s, frame, map, out)) continue;
    sightings.push_back(s);
    unknown.detections.push_back(detection);
    phi.push_back(landmarks_.sighting(s).phi);
  }
  FrameCandidates candidates;
  std::vector<FrameHypothesis> found;
  if (!sightings.empty()) {
    candidates = find_candidates(frame, unknown, phi, map, coverage, now_.classes, options_,
                                 loops_.recent_since(), loops_.views(), landmarks_);
    found = find_hypotheses(candidates, options_);
    note_candidates(candidates, sightings, map);
  }
  const bool open = found.size() > 1 && map.keeps_all;
  if (open) keep_open(found, sightings, frame, map, out);
  if (!open && !found.empty()) {
    take_best(found.front(), sightings, frame, map, out);
    if (options_.use_ids) learn_ids(sightings);
  }
  if (map.explain) {
    explain_frame(landmarks_, noted, sightings, candidates, found, now_.classes, open, out.events);
  }
  judge_existence(seen, frame, map, noted, out);
}

bool LandmarkAssociation::take_identified(int sighting, const KeyframeView& frame,
                                          const MapView& map, Contribution& out) {
  const std::optional<std::int64_t> id = landmarks_.sighting(sighting).detection.id;
  if (!id) return false;
  const int* track = track_of_id_.find(*id);
  if (track != nullptr && landmarks_.track(*track).alive) {
    attach(sighting, *track, map, out);
  } else if (adopted_) {
    return false;
  } else {
    create(sighting, frame.T_map_robot, map, out);
    track_of_id_.set(*id, landmarks_.sighting(sighting).track);
  }
  return true;
}

void LandmarkAssociation::learn_ids(const std::vector<int>& sightings) {
  for (const int s : sightings) {
    const Sighting& sighting = landmarks_.sighting(s);
    if (sighting.detection.id && sighting.track >= 0) {
      track_of_id_.set(*sighting.detection.id, sighting.track);
    }
  }
}

/// What was asked of the map about the candidates of a frame serves those that follow.
void LandmarkAssociation::note_candidates(const FrameCandidates& candidates,
                                          const std::vector<int>& sightings, const MapView& map) {
  for (std::size_t j = 0; j < candidates.tracks.size(); ++j) {
    landmarks_.set(candidates.tracks[j], &Track::sigma, candidates.sigmas[j]);
    landmarks_.place(candidates.tracks[j], map.values);
  }
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    landmarks_.sighting(sightings[i]).undetected = candidates.undetected[i];
  }
}

void LandmarkAssociation::attach(int sighting, int track, const MapView& map, Contribution& out) {
  landmarks_.attach(sighting, track, map.is_3d, out);
  landmarks_.set(track, &Track::last_keyframe, now_.keyframe);
  merging_.sighted(track, now_.keyframe, landmarks_.track(track).sightings.size());
}

void LandmarkAssociation::create(int sighting, const Eigen::Isometry3d& T_map_robot,
                                 const MapView& map, Contribution& out) {
  const int track = landmarks_.create(sighting, T_map_robot, now_.classes, map.is_3d, out);
  landmarks_.track(track).last_keyframe = now_.keyframe;
  landmarks_.track(track).sigma = landmarks_.sighting(sighting).detection.range;
  landmarks_.track(track).existence =
      std::log(options_.landmarks_in_view / options_.clutter_in_view);
  merging_.sighted(track, now_.keyframe, landmarks_.track(track).sightings.size());
}

void LandmarkAssociation::take_best(const FrameHypothesis& best, const std::vector<int>& sightings,
                                    const KeyframeView& frame, const MapView& map,
                                    Contribution& out) {
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    if (best.track[i] >= 0) {
      attach(sightings[i], best.track[i], map, out);
    } else {
      create(sightings[i], frame.T_map_robot, map, out);
    }
  }
}

/// Detections that all hypotheses agree about are decided. The others follow the best one until
/// their frame is opened.
void LandmarkAssociation::keep_open(std::vector<FrameHypothesis> hypotheses,
                                    const std::vector<int>& sightings, const KeyframeView& frame,
                                    const MapView& map, Contribution& out) {
  const std::vector<bool> disputed = OpenMatchings::disputed(hypotheses);
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const int best = hypotheses.front().track[i];
    if (best >= 0) attach(sightings[i], best, map, out);
    if (best < 0 && !disputed[i]) create(sightings[i], frame.T_map_robot, map, out);
  }
  now_.open.keep(std::move(hypotheses), sightings, landmarks_);
}

/// Gives the sightings of frames that are decided their landmarks in place of the mixtures.
void LandmarkAssociation::follow_decisions(const std::vector<OpenMatchings::Decided>& frames,
                                           const MapView& map, Contribution& out) {
  for (const OpenMatchings::Decided& frame : frames) {
    if (frame.is_revised) ++now_.statistics["frames_revised"];
    for (const auto& [s, t] : frame.tracks) {
      const Sighting& sighting = landmarks_.sighting(s);
      if (!map.holds(sighting.pose)) continue;  // its variable has left with its pose
      landmarks_.detach(s, out);
      if (!sighting.detection.may_be_landmark()) {
        ++out.dropped[MovingThings::kDropped];
      } else if (t >= 0) {
        landmarks_.attach(s, t, map.is_3d, out);
      } else {
        create(s, isometry_at(map.values, sighting.pose), map, out);
      }
      if (map.explain) out.events.decisions.push_back({s, sighting.track, frame.is_revised});
    }
  }
}

/// Raises the odds of landmarks that were seen and lowers those of landmarks that should have been;
/// tentative ones that are improbable by now were clutter.
void LandmarkAssociation::judge_existence(const DetectionFrame& seen, const KeyframeView& frame,
                                          const MapView& map, const std::vector<int>& sightings,
                                          Contribution& out) {
  SensorCoverage& coverage = now_.coverage[seen.sensor_label];
  const Eigen::Isometry3d T_map_sensor = compose(frame.T_map_robot, seen.T_robot_sensor);
  const double detected = coverage.detection_probability(options_.detection_probability);
  // Clutter in the share of the view that is nearest to a landmark is taken for it.
  const double clutter = std::min(
      detected, options_.clutter_in_view / coverage.expected_in_view(options_.landmarks_in_view));
  double seen_now = 0;
  for (int s : sightings) {
    const int t = landmarks_.sighting(s).track;
    if (t < 0) continue;
    ++seen_now;
    const double odds = landmarks_.track(t).existence + std::log(detected / clutter);
    landmarks_.set(t, &Track::existence, std::min(kSureOdds, odds));
  }
  std::vector<int> missed;
  landmarks_.grid().visit_near(
      T_map_sensor.translation().x(), T_map_sensor.translation().y(), coverage.max_range,
      [&](int t) {
        const Track& track = landmarks_.track(t);
        // Where a landmark lies that was last seen long ago is known less well than this asks for.
        const bool long_ago = track.last_keyframe + options_.recent < now_.keyframe;
        if ((long_ago && track.known_sightings == 0) || !map.holds(track.position)) return;
        if (track.last_keyframe == now_.keyframe || track.open > 0) return;
        if (coverage.well_in_view(T_map_sensor, point_at(map.values, track.position))) {
          missed.push_back(t);
        }
      });
  const double in_view = seen_now + static_cast<double>(missed.size());
  coverage.detections += seen_now;
  coverage.around += seen_now * in_view;
  coverage.in_view += in_view;
  coverage.seen += seen_now;
  const double miss = std::log((1 - detected) / (1 - clutter));
  for (int t : missed) {
    const Track& track = landmarks_.track(t);
    landmarks_.set(t, &Track::existence, track.existence + miss);
    const bool tentative =
        !landmarks_.seen_times(t, options_.confirm) && track.known_sightings == 0;
    if (tentative && track.existence < -std::log(options_.clutter_odds) && map.keeps_all)
      discard(t, map, out);
  }
}

void LandmarkAssociation::discard(int track, const MapView& map, Contribution& out) {
  const std::vector<int> sightings = landmarks_.track(track).sightings;
  if (!map.keeps_all || !landmarks_.is_whole(track, map)) {
    landmarks_.retire(track, out);
  } else {
    for (int s : sightings) landmarks_.detach(s, out);
    landmarks_.remove(track, out);
  }
  out.dropped["detection taken for clutter: its landmark was not seen again"] += sightings.size();
}

std::vector<AssociationDecision> LandmarkAssociation::decisions(const MapView& map) const {
  const std::map<int, int> now = now_.open.tracks(map);  // of undecided sightings
  std::vector<AssociationDecision> out;
  for (std::size_t s = 0; s < landmarks_.sightings().size(); ++s) {
    const Sighting& sighting = landmarks_.sightings()[s];
    if (sighting.frame == 0) continue;  // of a landmark known before
    const auto it = now.find(static_cast<int>(s));
    const int t = it == now.end() ? sighting.track : it->second;
    AssociationDecision decision{std::nullopt, sighting.detection.true_id};
    if (t >= 0 && landmarks_.track(t).alive) decision.estimated_id = t;
    decision.mover = movers_.mover_of(static_cast<int>(s));
    if (sighting.detection.members.empty()) out.push_back(decision);
    for (const auto& true_id : sighting.detection.members) {
      decision.true_id = true_id;
      out.push_back(decision);
    }
  }
  return out;
}

std::map<std::string, double> LandmarkAssociation::statistics() const {
  std::map<std::string, double> out = now_.statistics;
  out["landmarks_tried"] = static_cast<double>(landmarks_.tracks().size());
  if (now_.detections > 0)
    out["detection_sigma_m"] = now_.sigmas / static_cast<double>(now_.detections);
  return out;
}

}  // namespace hybrid
