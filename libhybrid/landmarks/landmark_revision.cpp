// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// The second half of the class: what it changes its mind about.

#include <algorithm>
#include <set>
#include <utility>

#include "libhybrid/landmarks/landmark_association.h"
#include "libhybrid/landmarks/reassociation.h"

namespace hybrid {
namespace {

constexpr int kHalfSteps = 20;  // over all associations, at most

}  // namespace

void LandmarkAssociation::applied(const Outcome& outcome) {
  before_.reset();
  landmarks_.take_handles(outcome.handles);
  if (!outcome.exact) ++now_.statistics["updates_by_local_search"];
  if (!merge_) return;
  now_.matched_again = 0;  // each merge leaves one landmark fewer: this comes to an end
  if (merge_->loop) ++now_.statistics["loops_closed"];
  now_.statistics["landmarks_merged"] += static_cast<double>(merge_->pairs.size());
  for (const auto& [from, into] : merge_->pairs)
    merging_.sighted(into, landmarks_.track(into).last_keyframe, 1);
  merge_.reset();
}

/// Before each contribution: what there is to go back to where it is refused. What grows with the
/// map notes its changes, the rest is copied.
void LandmarkAssociation::remember() {
  before_ = now_;
  landmarks_.remember();
  merging_.remember();
  loops_.remember();
  movers_.remember();
  track_of_id_.commit();
}

void LandmarkAssociation::refused() {
  if (!before_) return;
  now_ = std::move(*before_);
  before_.reset();
  landmarks_.take_back();
  merging_.take_back();
  loops_.take_back();
  movers_.take_back();
  track_of_id_.roll_back();
  now_.open.count(landmarks_);
  if (!merge_) return;
  merging_.refuse(*merge_, landmarks_);
  ++now_.statistics["merges_taken_back"];
  merge_.reset();
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
  return next_merge(map, false);
}

Contribution LandmarkAssociation::next_merge(const MapView& map, bool everything) {
  Merge merge =
      merging_.propose(map, now_.classes, now_.density, now_.keyframe, everything, landmarks_);
  merging_.note(merge);
  keep_whole(map, merge);
  if (merge.pairs.empty()) {
    merge = loops_.propose(map, now_.classes, now_.density, everything, landmarks_);
    loops_.note(everything, landmarks_);
    keep_whole(map, merge);
  }
  if (merge.pairs.empty()) return {};
  Contribution decided = decide_before(merge, map);
  return decided.empty() ? apply(merge, map) : decided;
}

/// Decides the frames that are open between the landmarks of a merge, which is then proposed again:
/// most are open because a landmark is in the map twice.
Contribution LandmarkAssociation::decide_before(const Merge& merge, const MapView& map) {
  Contribution out;
  follow_decisions(now_.open.decide_about(merge.pairs, map, landmarks_), map, out);
  return out;
}

/// Leaves out the landmarks of which sightings have left the graph: they cannot be given to others.
void LandmarkAssociation::keep_whole(const MapView& map, Merge& merge) {
  Merge left_out;
  auto& pairs = merge.pairs;
  const auto first_out = std::stable_partition(pairs.begin(), pairs.end(), [&](const auto& pair) {
    return landmarks_.is_whole(pair.first, map);
  });
  left_out.pairs.assign(first_out, pairs.end());
  pairs.erase(first_out, pairs.end());
  if (!left_out.pairs.empty()) merging_.refuse(left_out, landmarks_);
}

/// What a merge is worth shows in the objective only once the map has settled: it may move as far
/// as the drift, over which one linear step does not come.
Contribution LandmarkAssociation::apply(const Merge& merge, const MapView& map) {
  Contribution out;
  out.allowed_rise = merge.allowed_rise();
  for (const auto& [from, into] : merge.pairs) {
    const std::vector<int> moved = landmarks_.track(from).sightings;
    landmarks_.merge(from, into, map.is_3d, out);
    for (int s : moved) {
      if (map.explain && landmarks_.sighting(s).track < 0) {
        out.events.decisions.push_back({s, std::nullopt, true});
      }
    }
  }
  merge_ = merge;
  if (map.explain) out.events.merges.push_back(event_of(merge));
  return out;
}

/// A merge as it is told to those who ask why.
MergeEvent LandmarkAssociation::event_of(const Merge& merge) {
  MergeEvent event;
  event.pairs.assign(merge.pairs.begin(), merge.pairs.end());
  event.loop = merge.loop;
  event.evidence = merge.evidence;
  event.chi_square = merge.chi_square;
  return event;
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
    Contribution out = next_merge(map, true);
    if (out.empty()) out = match_again(map);
    if (out.empty()) {
      Merge merge =
          merging_.propose_by_misses(map, now_.classes, now_.density, loops_.views(), landmarks_);
      keep_whole(map, merge);
      if (merge.pairs.empty()) {
        merge = merging_.propose_by_counting(map, now_.classes, loops_.views(), landmarks_);
      }
      if (!merge.pairs.empty()) out = apply(merge, map);
    }
    if (!out.empty()) return out;
  }
  Contribution out;
  for (int t = 0; t < static_cast<int>(landmarks_.tracks().size()); ++t) {
    const Track& track = landmarks_.track(t);
    const bool confirmed = landmarks_.seen_times(t, options_.confirm);
    if (track.known_sightings > 0) continue;  // what becomes of it is for the map to say
    const bool named = options_.use_ids && landmarks_.has_id(t);  // which clutter is not
    const bool there = track.existence > 0 || named;
    if (track.alive && !(confirmed && there)) discard(t, map, out);
  }
  return out;
}

}  // namespace hybrid
