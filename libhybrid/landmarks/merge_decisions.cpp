// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/merge_decisions.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace hybrid {
namespace {

/// A merge as it is told to those who ask why.
MergeEvent event_of(const Merge& merge) {
  MergeEvent event;
  event.pairs.assign(merge.pairs.begin(), merge.pairs.end());
  event.loop = merge.loop;
  event.evidence = merge.evidence;
  event.chi_square = merge.chi_square;
  return event;
}

}  // namespace

Merge MergeDecisions::next(const MapView& map, const ClassModel& classes, double density,
                           int keyframe, bool everything, const LandmarkTracks& landmarks) {
  Merge merge = merging_.propose(map, classes, density, keyframe, everything, landmarks);
  merging_.note(merge);
  keep_whole(map, landmarks, merge);
  if (!merge.pairs.empty()) return merge;
  merge = loops_.propose(map, classes, density, everything, landmarks);
  loops_.note(everything, landmarks);
  keep_whole(map, landmarks, merge);
  return merge;
}

Merge MergeDecisions::next_by_looks(const MapView& map, const ClassModel& classes, double density,
                                    const LandmarkTracks& landmarks) {
  Merge merge = merging_.propose_by_misses(map, classes, density, views(), landmarks);
  keep_whole(map, landmarks, merge);
  if (!merge.pairs.empty()) return merge;
  return merging_.propose_by_counting(map, classes, views(), landmarks);
}

/// Leaves out the landmarks of which sightings have left the graph: they cannot be given to others.
void MergeDecisions::keep_whole(const MapView& map, const LandmarkTracks& landmarks, Merge& merge) {
  Merge left_out;
  auto& pairs = merge.pairs;
  const auto first_out = std::stable_partition(pairs.begin(), pairs.end(), [&](const auto& pair) {
    return landmarks.is_whole(pair.first, map);
  });
  left_out.pairs.assign(first_out, pairs.end());
  pairs.erase(first_out, pairs.end());
  if (!left_out.pairs.empty()) merging_.refuse(left_out, landmarks);
}

Contribution MergeDecisions::try_out(const Merge& merge, const MapView& map,
                                     LandmarkTracks& landmarks) {
  Contribution out;
  out.allowed_rise = merge.allowed_rise();
  for (const auto& [from, into] : merge.pairs) {
    const std::vector<int> moved = landmarks.track(from).sightings;
    landmarks.merge(from, into, map.is_3d, out);
    for (const int s : moved) {
      if (map.explain && landmarks.sighting(s).track < 0) {
        out.events.decisions.push_back({s, std::nullopt, true});
      }
    }
  }
  on_trial_ = merge;
  if (map.explain) out.events.merges.push_back(event_of(merge));
  return out;
}

std::optional<Merge> MergeDecisions::applied(const LandmarkTracks& landmarks) {
  if (!on_trial_) return std::nullopt;
  for (const auto& [from, into] : on_trial_->pairs)
    merging_.sighted(into, landmarks.track(into).last_keyframe, 1);
  return std::exchange(on_trial_, std::nullopt);
}

bool MergeDecisions::refused(const LandmarkTracks& landmarks) {
  if (!on_trial_) return false;
  merging_.refuse(*on_trial_, landmarks);
  on_trial_.reset();
  return true;
}

void MergeDecisions::remember() {
  merging_.remember();
  loops_.remember();
}

void MergeDecisions::take_back() {
  merging_.take_back();
  loops_.take_back();
}

}  // namespace hybrid
