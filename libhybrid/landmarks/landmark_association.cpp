// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/landmark_association.h"

#include <algorithm>
#include <set>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/landmarks/existence.h"
#include "libhybrid/landmarks/explain.h"
#include "libhybrid/landmarks/reassociation.h"

namespace hybrid {
namespace {

/// Landmarks whose place in the grid follows the estimate, each keyframe: a budget of time. Those
/// that are candidates of its detections do besides.
constexpr int kPlacedAtOnce = 40;
/// Numbers of landmarks that a map may have had, one after the other: some 300 bytes each are kept.
constexpr std::int64_t kMostIds = 1'000'000;
constexpr int kHalfSteps = 20;  // over all associations at the end, at most

}  // namespace

LandmarkAssociation::LandmarkAssociation(const AssociationOptions& options, ClassModel classes,
                                         std::vector<std::string> sensors)
    : sensors_(std::move(sensors)), options_(options), merges_(options), movers_(options) {
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

Contribution LandmarkAssociation::observe(const KeyframeView& frame, const MapView& map) {
  Contribution out;
  merges_.forget(now_.keyframe);
  remember();
  ++now_.keyframe;
  follow_decisions(now_.open.decide_until(now_.keyframe - options_.window, map, landmarks_), map,
                   out);
  landmarks_.place_some(map.values, kPlacedAtOnce);
  for (const DetectionFrame& seen : frame.detections) {
    if (!is_wanted(seen.sensor_label, sensors_)) continue;
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
    if (!named) sighting.extent = now_.classes.extent_of(options_.extent, sighting.phi);
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
  merges_.looked(frame, seen.T_robot_sensor, coverage, now_.density, map);
  if (!seen.class_names.empty()) now_.classes.learn_names(seen.class_names);
  auto sensor = std::make_shared<DetectionFrame>(seen);
  sensor->detections.clear();
  DetectionFrame unknown = *sensor;
  FrameMatching matching;
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
    matching.sightings.push_back(s);
    unknown.detections.push_back(detection);
    phi.push_back(landmarks_.sighting(s).phi);
  }
  const std::vector<int>& sightings = matching.sightings;
  const std::vector<FrameHypothesis>& found = matching.hypotheses;
  if (!sightings.empty()) {
    matching.candidates = find_candidates(
        frame, unknown, phi, map,
        {options_, coverage, now_.classes, merges_.views(), merges_.recent_since(), landmarks_});
    matching.hypotheses = find_hypotheses(matching.candidates, options_);
    note_candidates(matching.candidates, sightings, map, landmarks_);
  }
  matching.open = found.size() > 1 && map.keeps_all;
  if (matching.open) keep_open(found, sightings, frame, map, out);
  if (!matching.open && !found.empty()) {
    take_best(found.front(), sightings, frame, map, out);
    if (options_.use_ids) learn_ids(sightings);
  }
  if (map.explain) explain_frame(landmarks_, noted, matching, now_.classes, out.events);
  const std::vector<int> missed =
      missed_landmarks(compose(frame.T_map_robot, seen.T_robot_sensor), coverage, map,
                       now_.keyframe, options_.recent, landmarks_);
  discard(judge_existence(noted, missed, map, options_, coverage, landmarks_), map, out);
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

void LandmarkAssociation::attach(int sighting, int track, const MapView& map, Contribution& out) {
  landmarks_.attach(sighting, track, map.is_3d, out);
  landmarks_.set(track, &Track::last_keyframe, now_.keyframe);
  merges_.sighted(track, now_.keyframe, landmarks_);
}

void LandmarkAssociation::create(int sighting, const Eigen::Isometry3d& T_map_robot,
                                 const MapView& map, Contribution& out) {
  const int track = landmarks_.create(sighting, T_map_robot, now_.classes, map.is_3d, out);
  landmarks_.track(track).last_keyframe = now_.keyframe;
  landmarks_.track(track).sigma = landmarks_.sighting(sighting).detection.range;
  landmarks_.track(track).existence = existence_at_birth(options_);
  merges_.sighted(track, now_.keyframe, landmarks_);
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

void LandmarkAssociation::discard(const std::vector<int>& tracks, const MapView& map,
                                  Contribution& out) {
  for (const int t : tracks) {
    const std::size_t sightings = landmarks_.track(t).sightings.size();
    landmarks_.discard(t, map, out);
    out.dropped["detection taken for clutter: its landmark was not seen again"] += sightings;
  }
}

void LandmarkAssociation::applied(const Outcome& outcome) {
  before_.reset();
  landmarks_.take_handles(outcome.handles);
  if (!outcome.exact) ++now_.statistics["updates_by_local_search"];
  const std::optional<Merge> merge = merges_.applied(landmarks_);
  if (!merge) return;
  now_.matched_again = 0;  // each merge leaves one landmark fewer: this comes to an end
  if (merge->loop) ++now_.statistics["loops_closed"];
  now_.statistics["landmarks_merged"] += static_cast<double>(merge->pairs.size());
}

/// Before each contribution: what there is to go back to where it is refused. What grows with the
/// map notes its changes, the rest is copied.
void LandmarkAssociation::remember() {
  before_ = now_;
  landmarks_.remember();
  merges_.remember();
  movers_.remember();
  track_of_id_.commit();
}

void LandmarkAssociation::refused() {
  if (!before_) return;
  now_ = std::move(*before_);
  before_.reset();
  landmarks_.take_back();
  merges_.take_back();
  movers_.take_back();
  track_of_id_.roll_back();
  now_.open.count(landmarks_);
  if (merges_.refused(landmarks_)) ++now_.statistics["merges_taken_back"];
}

Contribution LandmarkAssociation::revise(const MapView& map) {
  return answered_if_empty(next_revision(map));
}

Contribution LandmarkAssociation::conclude(const MapView& map) {
  return answered_if_empty(next_conclusion(map));
}

/// Of nothing nobody says what became of it, so that there is nothing to go back to.
Contribution LandmarkAssociation::answered_if_empty(Contribution out) {
  if (out.empty()) before_.reset();
  return out;
}

Contribution LandmarkAssociation::next_revision(const MapView& map) {
  // What cannot be opened is not tried again.
  const std::vector<OpenMatchings::Kept> kept = now_.open.take_kept();
  remember();
  Contribution out;
  for (const OpenMatchings::Kept& frame : kept) {
    now_.open.open(frame, now_.keyframe, map, landmarks_, out);
  }
  if (!kept.empty()) {
    now_.statistics["frames_left_open"] += static_cast<double>(kept.size());
    return out;
  }
  movers_.withdraw(now_.open.sightings(), map, landmarks_, out);
  if (!out.empty()) return out;
  if (!options_.merge || !map.keeps_all) return {};
  return try_out(merges_.next(map, now_.classes, now_.density, now_.keyframe, false, landmarks_),
                 map);
}

/// Frames that are open between the landmarks of a merge are decided first, and it is proposed
/// again: most are open because a landmark is in the map twice.
Contribution LandmarkAssociation::try_out(const Merge& merge, const MapView& map) {
  Contribution out;
  if (merge.pairs.empty()) return out;
  follow_decisions(now_.open.decide_about(merge.pairs, map, landmarks_), map, out);
  return out.empty() ? merges_.try_out(merge, map, landmarks_) : out;
}

/// Alternates (eq. 8): what belongs to what, given the estimate. Landmarks without sightings go.
Contribution LandmarkAssociation::match_again(const MapView& map) {
  Contribution out;
  if (now_.matched_again == kHalfSteps) return out;
  ++now_.matched_again;
  std::set<int> emptied;
  for (const auto& [s, t] : reassociate(map, now_.classes, now_.coverage, options_,
                                        track_of_id_.entries(), landmarks_)) {
    const int before = landmarks_.sighting(s).track;
    landmarks_.detach(s, out);
    if (t >= 0) attach(s, t, map, out);
    if (before >= 0 && landmarks_.track(before).sightings.empty()) emptied.insert(before);
    ++now_.statistics["sightings_matched_again"];
    if (!map.explain) continue;
    DecisionEvent event{s, std::nullopt, true};
    if (t >= 0) event.landmark = t;
    out.events.decisions.push_back(event);
  }
  for (int t : emptied) {
    if (landmarks_.track(t).sightings.empty()) landmarks_.remove(t, out);
  }
  out.settle = true;
  return out;
}

Contribution LandmarkAssociation::next_conclusion(const MapView& map) {
  remember();
  if (!now_.open.empty()) {
    Contribution out;
    follow_decisions(now_.open.decide_until(now_.keyframe, map, landmarks_), map, out);
    return out;
  }
  movers_.decide(map, landmarks_);
  Contribution withdrawn;
  movers_.withdraw(now_.open.sightings(), map, landmarks_, withdrawn);
  if (!withdrawn.empty()) return withdrawn;
  if (options_.merge && map.keeps_all) {
    landmarks_.place_all(map.values);
    Contribution out = try_out(
        merges_.next(map, now_.classes, now_.density, now_.keyframe, true, landmarks_), map);
    if (out.empty()) out = match_again(map);
    if (out.empty())
      out = try_out(merges_.next_by_looks(map, now_.classes, now_.density, landmarks_), map);
    if (!out.empty()) return out;
  }
  Contribution out;
  discard(never_confirmed(options_, landmarks_), map, out);
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
