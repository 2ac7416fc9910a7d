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
  landmarks_.take_handles(outcome.handles);
  if (!outcome.exact) ++statistics_["updates_by_local_search"];
  if (!merge_) return;
  matched_again_ = 0;  // each merge leaves one landmark fewer: this comes to an end
  if (merge_->loop) ++statistics_["loops_closed"];
  statistics_["landmarks_merged"] += static_cast<double>(merge_->pairs.size());
  for (const auto& [from, into] : merge_->pairs)
    merging_.sighted(into, landmarks_.track(into).last_keyframe, 1);
  merge_.reset();
}

/// Before each contribution: what there is to go back to where it is refused.
void LandmarkAssociation::remember() {
  open_before_ = open_;
}

/// Nothing of the last contribution is in the map: its detections belong to nothing, its frames are
/// as open as they were, and the merge that it made is not proposed again.
void LandmarkAssociation::refused() {
  landmarks_.take_back();
  ambiguous_.clear();
  open_ = open_before_;
  count_open();
  for (auto it = track_of_id_.begin(); it != track_of_id_.end();) {
    it = landmarks_.track(it->second).alive ? std::next(it) : track_of_id_.erase(it);
  }
  if (!merge_) return;
  merging_.refuse(*merge_, landmarks_);
  ++statistics_["merges_taken_back"];
  merge_.reset();
}

/// Counts the open frames of each track anew.
void LandmarkAssociation::count_open() {
  for (int t = 0; t < static_cast<int>(landmarks_.tracks().size()); ++t)
    landmarks_.track(t).open = 0;
  for (const OpenFrame& open : open_) {
    for (const std::vector<int>& tracks : open.tracks) {
      for (int t : tracks) {
        if (t >= 0) ++landmarks_.track(t).open;
      }
    }
  }
}

Contribution LandmarkAssociation::revise(const MapView& map) {
  remember();
  if (!ambiguous_.empty()) {
    Contribution out;
    for (const AmbiguousFrame& frame : ambiguous_) leave_open(frame, map, out);
    ambiguous_.clear();
    return out;
  }
  Contribution out;
  withdraw_movers(map, out);
  if (!out.empty()) return out;
  if (!options_.merge || !map.keeps_all) return {};
  return next_merge(map, false);
}

Contribution LandmarkAssociation::next_merge(const MapView& map, bool everything) {
  Merge merge = merging_.propose(map, classes_, density_, keyframe_, everything, landmarks_);
  keep_whole(map, merge);
  if (merge.pairs.empty()) {
    merge = loops_.propose(map, classes_, density_, everything, landmarks_);
    keep_whole(map, merge);
  }
  if (merge.pairs.empty()) return {};
  Contribution decided = decide_before(merge, map);
  return decided.empty() ? apply(merge, map) : decided;
}

/// Decides the frames that are open between the landmarks of a merge, which is then proposed again:
/// most are open because a landmark is in the map twice.
Contribution LandmarkAssociation::decide_before(const Merge& merge, const MapView& map) {
  const auto concerns = [&](const OpenFrame& open) {
    for (const std::vector<int>& tracks : open.tracks) {
      for (const auto& [from, into] : merge.pairs) {
        if (std::find(tracks.begin(), tracks.end(), from) != tracks.end()) return true;
        if (std::find(tracks.begin(), tracks.end(), into) != tracks.end()) return true;
      }
    }
    return false;
  };
  Contribution out;
  const auto first = std::stable_partition(open_.begin(), open_.end(),
                                           [&](const OpenFrame& open) { return !concerns(open); });
  const std::vector<OpenFrame> concerned(first, open_.end());
  open_.erase(first, open_.end());
  for (const OpenFrame& open : concerned) decide(open, map, out);
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
  if (matched_again_ == kHalfSteps) return out;
  ++matched_again_;
  std::set<int> emptied;
  for (const auto& [s, t] :
       reassociate(map, classes_, coverage_, options_, track_of_id_, landmarks_)) {
    const int before = landmarks_.sighting(s).track;
    landmarks_.detach(s, out);
    if (t >= 0) attach(s, t, map, out);
    if (before >= 0 && landmarks_.track(before).sightings.empty()) emptied.insert(before);
    ++statistics_["sightings_matched_again"];
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

Contribution LandmarkAssociation::conclude(const MapView& map) {
  remember();
  if (!open_.empty()) {
    Contribution out;
    decide_old(map, keyframe_, out);
    return out;
  }
  if (!things_are_decided_) things_.decide(locate(map));
  things_are_decided_ = true;
  Contribution withdrawn;
  withdraw_movers(map, withdrawn);
  if (!withdrawn.empty()) return withdrawn;
  if (options_.merge && map.keeps_all) {
    landmarks_.place_all(map.values);
    Contribution out = next_merge(map, true);
    if (out.empty()) out = match_again(map);
    if (out.empty()) {
      Merge merge = merging_.propose_by_misses(map, classes_, density_, loops_.views(), landmarks_);
      keep_whole(map, merge);
      if (merge.pairs.empty()) {
        merge = merging_.propose_by_counting(map, classes_, loops_.views(), landmarks_);
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
