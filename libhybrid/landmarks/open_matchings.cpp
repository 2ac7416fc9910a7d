// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/open_matchings.h"

#include <algorithm>
#include <memory>

#include "libhybrid/association/association_factor.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/hybrid/semantic.h"

namespace hybrid {
namespace {

void count_tracks(const std::vector<int>& tracks, int by, LandmarkTracks& landmarks) {
  for (const int t : tracks) {
    if (t >= 0) landmarks.track(t).open += by;
  }
}

/// A sighting as one of a track, or as of no landmark of the map.
AssociationOption option_of(int s, int t, double constant, bool is_3d,
                            const LandmarkTracks& landmarks) {
  AssociationOption option;
  option.constant = constant;
  if (t < 0) return option;
  const Sighting& sighting = landmarks.sighting(s);
  const Track& track = landmarks.track(t);
  option.factor = sighting_factor(sighting.pose, track.position, *sighting.sensor,
                                  landmarks.detection_of(s, t), is_3d);
  if (track.class_key && !sighting.phi.empty()) {
    option.classes = likelihood_table(*track.class_key, sighting.phi);
  }
  return option;
}

}  // namespace

std::vector<bool> OpenMatchings::disputed(const std::vector<FrameHypothesis>& hypotheses) {
  const std::vector<int>& best = hypotheses.front().track;
  std::vector<bool> out(best.size());
  for (std::size_t i = 0; i < best.size(); ++i) {
    out[i] = std::any_of(hypotheses.begin(), hypotheses.end(),
                         [&](const FrameHypothesis& h) { return h.track[i] != best[i]; });
  }
  return out;
}

void OpenMatchings::keep(std::vector<FrameHypothesis> hypotheses, const std::vector<int>& sightings,
                         LandmarkTracks& landmarks) {
  const std::vector<bool> is_open = disputed(hypotheses);
  Kept kept{std::move(hypotheses), {}, {}};
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    if (!is_open[i]) continue;
    for (const FrameHypothesis& h : kept.hypotheses) count_tracks({h.track[i]}, 1, landmarks);
    kept.rows.push_back(i);
    kept.sightings.push_back(sightings[i]);
  }
  kept_.push_back(std::move(kept));
}

/// One discrete variable for the frame, a value for each hypothesis.
void OpenMatchings::open(const Kept& frame, int keyframe, const MapView& map,
                         LandmarkTracks& landmarks, Contribution& out) {
  const std::size_t n = frame.hypotheses.size();
  Open open{
      keyframe,
      {Key(key_letter::kAssociation, static_cast<std::uint64_t>(opened_++)), static_cast<int>(n)},
      frame.sightings,
      std::vector<std::vector<int>>(n)};
  for (std::size_t i = 0; i < frame.rows.size(); ++i) {
    const int s = frame.sightings[i];
    std::vector<AssociationOption> options;
    for (std::size_t h = 0; h < n; ++h) {
      const int t = frame.hypotheses[h].track[frame.rows[i]];
      open.tracks[h].push_back(t);
      options.push_back(
          option_of(s, t, frame.hypotheses[h].constant[frame.rows[i]], map.is_3d, landmarks));
    }
    const int best = open.tracks.front().back();
    landmarks.detach(s, out);
    if (best >= 0) landmarks.count(s, best, out);
    landmarks.add_factor(s, std::make_shared<AssociationFactor>(open.choice, std::move(options)),
                         out);
  }
  open_.push_back(std::move(open));
}

template <class IsAsked>
std::vector<OpenMatchings::Decided> OpenMatchings::decide(const IsAsked& is_asked,
                                                          const MapView& map,
                                                          LandmarkTracks& landmarks) {
  std::vector<Decided> out;
  const auto first = std::stable_partition(open_.begin(), open_.end(),
                                           [&](const Open& open) { return !is_asked(open); });
  for (auto open = first; open != open_.end(); ++open) {
    const int value = map.assignment.at(open->choice.key);
    Decided decided{value != 0, {}};
    for (const std::vector<int>& tracks : open->tracks) count_tracks(tracks, -1, landmarks);
    for (std::size_t i = 0; i < open->sightings.size(); ++i) {
      decided.tracks.emplace_back(open->sightings[i], open->tracks[value][i]);
    }
    out.push_back(std::move(decided));
  }
  open_.erase(first, open_.end());
  return out;
}

std::vector<OpenMatchings::Decided> OpenMatchings::decide_until(int keyframe, const MapView& map,
                                                                LandmarkTracks& landmarks) {
  return decide([&](const Open& open) { return open.keyframe <= keyframe; }, map, landmarks);
}

std::vector<OpenMatchings::Decided> OpenMatchings::decide_about(
    const std::vector<std::pair<int, int>>& pairs, const MapView& map, LandmarkTracks& landmarks) {
  const auto concerns = [&](const Open& open) {
    for (const std::vector<int>& tracks : open.tracks) {
      for (const auto& [from, into] : pairs) {
        if (std::find(tracks.begin(), tracks.end(), from) != tracks.end()) return true;
        if (std::find(tracks.begin(), tracks.end(), into) != tracks.end()) return true;
      }
    }
    return false;
  };
  return decide(concerns, map, landmarks);
}

std::set<int> OpenMatchings::sightings() const {
  std::set<int> out;
  for (const Open& open : open_) out.insert(open.sightings.begin(), open.sightings.end());
  return out;
}

std::map<int, int> OpenMatchings::tracks(const MapView& map) const {
  std::map<int, int> out;
  for (const Open& open : open_) {
    const std::vector<int>& tracks = open.tracks[map.assignment.at(open.choice.key)];
    for (std::size_t i = 0; i < tracks.size(); ++i) out[open.sightings[i]] = tracks[i];
  }
  return out;
}

void OpenMatchings::count(LandmarkTracks& landmarks) const {
  for (int t = 0; t < static_cast<int>(landmarks.tracks().size()); ++t) landmarks.track(t).open = 0;
  for (const Kept& frame : kept_) {
    for (const FrameHypothesis& h : frame.hypotheses) {
      for (const std::size_t row : frame.rows) count_tracks({h.track[row]}, 1, landmarks);
    }
  }
  for (const Open& open : open_) {
    for (const std::vector<int>& tracks : open.tracks) count_tracks(tracks, 1, landmarks);
  }
}

}  // namespace hybrid
