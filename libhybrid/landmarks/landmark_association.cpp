// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/landmark_association.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/association/association_factor.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/hybrid/semantic.h"
#include "libhybrid/landmarks/explain.h"
#include "libhybrid/landmarks/sighting.h"

namespace hybrid {
namespace {

/// Landmarks whose place in the grid follows the estimate, each keyframe: a budget of time. Those
/// that are candidates of its detections do besides.
constexpr int kPlacedAtOnce = 40;
constexpr double kSureOdds = 12.0;  // log odds of existence above which they do not grow

}  // namespace

LandmarkAssociation::LandmarkAssociation(const AssociationOptions& options, ClassModel classes,
                                         std::vector<std::string> sensors)
    : sensors_(std::move(sensors)),
      options_(options),
      merging_(options),
      loops_(options),
      things_(options.motion) {
  now_.classes = std::move(classes);
}

Contribution LandmarkAssociation::observe(const KeyframeView& frame, const MapView& map) {
  Contribution out;
  merging_.forget(now_.keyframe);
  remember();
  ++now_.keyframe;
  now_.things_are_decided = false;
  decide_old(map, now_.keyframe - options_.window, out);
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
    sighting.extent = named ? 0 : options_.extent;
    const std::vector<double>& scores = sighting.detection.class_probabilities;
    if (!scores.empty() && now_.classes.names().size() > 1) {
      sighting.phi = now_.classes.likelihood(scores, seen.class_names);
    }
    noted.push_back(landmarks_.note(std::move(sighting)));
  }
  return noted;
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
  follow(noted, frame, coverage, map);
  for (const int s : noted) {
    const Detection& detection = landmarks_.sighting(s).detection;
    if (!detection.may_be_landmark()) {
      ++out.dropped[kMoving];
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
                                 loops_.local_since(), loops_.views(), landmarks_);
    found = find_hypotheses(candidates, options_);
    note_candidates(candidates, sightings, map);
  }
  const bool open = found.size() > 1 && map.keeps_all;
  if (open) keep_ambiguous(found, sightings, frame, map, out);
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
/// the estimate has come to terms with it: before that, distances mean little.
void LandmarkAssociation::keep_ambiguous(std::vector<FrameHypothesis> hypotheses,
                                         const std::vector<int>& sightings,
                                         const KeyframeView& frame, const MapView& map,
                                         Contribution& out) {
  AmbiguousFrame ambiguous{std::move(hypotheses), {}, {}};
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const int first = ambiguous.hypotheses.front().track[i];
    const bool agreed = std::all_of(ambiguous.hypotheses.begin(), ambiguous.hypotheses.end(),
                                    [&](const auto& h) { return h.track[i] == first; });
    if (first >= 0) attach(sightings[i], first, map, out);
    if (agreed && first < 0) create(sightings[i], frame.T_map_robot, map, out);
    if (agreed) continue;
    for (const FrameHypothesis& h : ambiguous.hypotheses) {
      if (h.track[i] >= 0) ++landmarks_.track(h.track[i]).open;
    }
    ambiguous.rows.push_back(i);
    ambiguous.sightings.push_back(sightings[i]);
  }
  now_.ambiguous.push_back(std::move(ambiguous));
}

/// One discrete variable for the frame, a value for each hypothesis.
void LandmarkAssociation::leave_open(const AmbiguousFrame& frame, const MapView& map,
                                     Contribution& out) {
  const std::size_t n = frame.hypotheses.size();
  OpenFrame open{now_.keyframe,
                 {Key(key_letter::kAssociation, static_cast<std::uint64_t>(now_.opened++)),
                  static_cast<int>(n)},
                 frame.sightings,
                 std::vector<std::vector<int>>(n)};
  for (std::size_t i = 0; i < frame.rows.size(); ++i) {
    const int s = frame.sightings[i];
    const Sighting& sighting = landmarks_.sighting(s);
    std::vector<AssociationOption> options;
    for (std::size_t h = 0; h < n; ++h) {
      const int t = frame.hypotheses[h].track[frame.rows[i]];
      AssociationOption option;
      option.constant = frame.hypotheses[h].constant[frame.rows[i]];
      open.tracks[h].push_back(t);
      if (t >= 0) {
        const Track& track = landmarks_.track(t);
        option.factor = sighting_factor(sighting.pose, track.position, *sighting.sensor,
                                        landmarks_.detection_of(s, t), map.is_3d);
        if (track.class_key && !sighting.phi.empty()) {
          option.classes = likelihood_table(*track.class_key, sighting.phi);
        }
      }
      options.push_back(std::move(option));
    }
    const int best = open.tracks.front().back();
    landmarks_.detach(s, out);
    if (best >= 0) landmarks_.count(s, best, out);
    landmarks_.add_factor(s, std::make_shared<AssociationFactor>(open.choice, std::move(options)),
                          out);
  }
  ++now_.statistics["frames_left_open"];
  now_.open.push_back(std::move(open));
}

/// Replaces the mixture of a frame by what its variable has come to.
void LandmarkAssociation::decide(const OpenFrame& open, const MapView& map, Contribution& out) {
  const int value = map.assignment.at(open.choice.key);
  if (value != 0) ++now_.statistics["frames_revised"];
  for (std::size_t i = 0; i < open.sightings.size(); ++i) {
    for (const std::vector<int>& tracks : open.tracks) {
      if (tracks[i] >= 0) --landmarks_.track(tracks[i]).open;
    }
    const int s = open.sightings[i], t = open.tracks[value][i];
    if (!map.holds(landmarks_.sighting(s).pose)) continue;  // its variable has left with its pose
    landmarks_.detach(s, out);
    if (!landmarks_.sighting(s).detection.may_be_landmark()) {
      ++out.dropped[kMoving];
    } else if (t >= 0) {
      landmarks_.attach(s, t, map.is_3d, out);
    } else {
      create(s, isometry_at(map.values, landmarks_.sighting(s).pose), map, out);
    }
    if (map.explain) {
      out.events.decisions.push_back({s, landmarks_.sighting(s).track, value != 0});
    }
  }
}

void LandmarkAssociation::decide_old(const MapView& map, int before, Contribution& out) {
  std::size_t done = 0;
  while (done < now_.open.size() && now_.open[done].keyframe <= before)
    decide(now_.open[done++], map, out);
  now_.open.erase(now_.open.begin(), now_.open.begin() + static_cast<std::ptrdiff_t>(done));
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
  std::map<int, int> now;  // of undecided sightings
  for (const OpenFrame& open : now_.open) {
    const std::vector<int>& tracks = open.tracks[map.assignment.at(open.choice.key)];
    for (std::size_t i = 0; i < tracks.size(); ++i) now[open.sightings[i]] = tracks[i];
  }
  std::vector<AssociationDecision> out;
  for (std::size_t s = 0; s < landmarks_.sightings().size(); ++s) {
    const Sighting& sighting = landmarks_.sightings()[s];
    if (sighting.frame == 0) continue;  // of a landmark known before
    const auto it = now.find(static_cast<int>(s));
    const int t = it == now.end() ? sighting.track : it->second;
    AssociationDecision decision{std::nullopt, sighting.detection.true_id};
    if (t >= 0 && landmarks_.track(t).alive) decision.estimated_id = t;
    decision.mover = things_.mover_of(static_cast<int>(s));
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
