// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/landmark_tracks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/discrete/class_evidence.h"
#include "libhybrid/discrete/probabilities.h"
#include "libhybrid/hybrid/semantic.h"
#include "libhybrid/landmarks/sensor_place.h"

namespace hybrid {
namespace {

constexpr int kContinuous = 0, kDiscrete = 1, kHybrid = 2;
constexpr double kLeastProbability = 1e-12;  // of a class of a known landmark

}  // namespace

int LandmarkTracks::note(Sighting sighting) {
  sightings_.push_back(std::move(sighting));
  undo_.emplace_back([](LandmarkTracks& all) { all.sightings_.pop_back(); });
  return static_cast<int>(sightings_.size()) - 1;
}

Detection LandmarkTracks::detection_of(int s, int t) const {
  const Sighting& sighting = sightings_[s];
  return with_extent(sighting.detection, t < 0 ? sighting.extent : tracks_[t].extent,
                     sighting.sensor->is_3d);
}

PointSighting LandmarkTracks::located(int s, int t, const Eigen::Isometry3d& T_map_robot,
                                      const Values& values, bool is_3d) const {
  const DetectionFrame& sensor = *sightings_[s].sensor;
  return point_sighting(sensor_pose(T_map_robot, sensor, values, is_3d), sensor.time,
                        detection_of(s, t), is_3d);
}

int LandmarkTracks::create(int s, const Eigen::Isometry3d& T_map_robot, const ClassModel& classes,
                           bool is_3d, Contribution& out) {
  const int t = static_cast<int>(tracks_.size());
  const Sighting& sighting = sightings_[s];
  Track track;
  track.position = Key(key_letter::kLandmark, static_cast<std::uint64_t>(t));
  const Eigen::Vector3d point = sighted_point(T_map_robot, *sighting.sensor, sighting.detection);
  insert_point(out.delta.values, track.position, point, is_3d);
  const std::size_t n = classes.names().size();
  if (n > 1) {
    track.class_key = DiscreteKey{Key(key_letter::kLandmarkClass, static_cast<std::uint64_t>(t)),
                                  static_cast<int>(n)};
    track.class_evidence.assign(n, 0.0);
    std::vector<double> p = classes.prior();
    for (std::size_t k = 0; k < sighting.phi.size(); ++k) p[k] *= sighting.phi[k];
    out.delta.discrete.push_back(prior_table(*track.class_key, classes.prior()));
    slots_[kDiscrete].push_back({-1, t});
    out.delta.assignment.set(track.class_key->key, most_probable(p));
  }
  out.landmarks.push_back({t, track.position, track.class_key, 0});
  track.undetected = sighting.undetected;
  track.extent = sighting.extent;
  tracks_.push_back(std::move(track));
  ++alive_;
  grid_.put(t, point.x(), point.y());
  undo_.emplace_back([t](LandmarkTracks& all) {
    all.tracks_.pop_back();
    --all.alive_;
    all.grid_.remove(t);
  });
  attach(s, t, is_3d, out);
  return t;
}

void LandmarkTracks::adopt(const std::vector<KnownLandmark>& landmarks, const ClassModel& classes,
                           bool is_3d) {
  const int dim = is_3d ? 3 : 2;
  for (const KnownLandmark& known : landmarks) {
    const int t = static_cast<int>(known.id);
    if (t >= static_cast<int>(tracks_.size())) {
      Track none;
      none.alive = false;
      tracks_.resize(static_cast<std::size_t>(t) + 1, none);
    }
    Track& track = tracks_[t];
    track.position = position_key(known.id);
    track.alive = true;
    track.existence = known.existence;
    track.sigma = std::sqrt(known.covariance.topLeftCorner(dim, dim).trace());
    track.known_sightings = std::max(1, known.sightings);
    track.known_things = known.size.things;
    track.extent = known.size.extent;
    Sighting sighting;
    if (!known.class_probabilities.empty()) {
      const std::vector<double> prior = classes.prior();
      track.class_key = DiscreteKey{Key(key_letter::kLandmarkClass, position_key(known.id).index()),
                                    static_cast<int>(prior.size())};
      track.class_evidence.assign(prior.size(), 0.0);
      for (std::size_t s = 0; s < prior.size(); ++s) {
        const double p = std::max(known.class_probabilities[s], kLeastProbability);
        sighting.phi.push_back(prior[s] > 0 ? p / prior[s] : 1.0);
      }
    }
    join(note(std::move(sighting)), t);
    ++alive_;
    grid_.put(t, known.position.x(), known.position.y());
  }
  remember();
}

/// Notes that sighting `s` belongs to track `t`.
void LandmarkTracks::join(int s, int t) {
  Track& track = tracks_[t];
  sightings_[s].track = t;
  track.sightings.insert(std::lower_bound(track.sightings.begin(), track.sightings.end(), s), s);
  if (track.class_key) add_class_likelihood(sightings_[s].phi, 1.0, track.class_evidence);
}

/// The reverse.
void LandmarkTracks::part(int s, int t) {
  Track& track = tracks_[t];
  sightings_[s].track = -1;
  track.sightings.erase(std::find(track.sightings.begin(), track.sightings.end(), s));
  if (track.class_key) add_class_likelihood(sightings_[s].phi, -1.0, track.class_evidence);
}

void LandmarkTracks::count(int s, int t, Contribution& out) {
  undo_.emplace_back([s, t, evidence = tracks_[t].class_evidence](LandmarkTracks& all) {
    all.part(s, t);
    all.tracks_[t].class_evidence = evidence;  // to the bit, which a difference is not
  });
  join(s, t);
  out.sighted.push_back(t);
}

void LandmarkTracks::attach(int s, int t, bool is_3d, Contribution& out) {
  Sighting& sighting = sightings_[s];
  const Track& track = tracks_[t];
  ContinuousFactorPtr psi =
      sighting_factor(sighting.pose, track.position, *sighting.sensor, detection_of(s, t), is_3d);
  if (track.class_key && !sighting.phi.empty()) {
    out.delta.hybrid.push_back(std::make_shared<WeightedFactor>(
        std::move(psi), likelihood_table(*track.class_key, sighting.phi)));
    slots_[kHybrid].push_back({s, -1});
  } else {
    out.delta.continuous.push_back(std::move(psi));
    slots_[kContinuous].push_back({s, -1});
  }
  count(s, t, out);
}

void LandmarkTracks::add_factor(int s, HybridFactorPtr factor, Contribution& out) {
  out.delta.hybrid.push_back(std::move(factor));
  slots_[kHybrid].push_back({s, -1});
}

void LandmarkTracks::detach(int s, Contribution& out) {
  Sighting& sighting = sightings_[s];
  out.delta.remove.insert(out.delta.remove.end(), sighting.factors.begin(), sighting.factors.end());
  undo_.emplace_back([s, factors = sighting.factors](LandmarkTracks& all) {
    all.sightings_[s].factors = factors;
  });
  sighting.factors.clear();
  const int t = sighting.track;
  if (t < 0) return;
  out.unsighted.push_back(t);
  undo_.emplace_back([s, t, evidence = tracks_[t].class_evidence](LandmarkTracks& all) {
    all.join(s, t);
    all.tracks_[t].class_evidence = evidence;
  });
  part(s, t);
}

void LandmarkTracks::remove(int t, Contribution& out) {
  Track& track = tracks_[t];
  out.delta.remove.insert(out.delta.remove.end(), track.prior.begin(), track.prior.end());
  undo_.emplace_back(
      [t, prior = track.prior](LandmarkTracks& all) { all.tracks_[t].prior = prior; });
  track.prior.clear();
  out.delta.remove_values.push_back(track.position);
  retire(t, out);
}

void LandmarkTracks::discard(int t, const MapView& map, Contribution& out) {
  if (!map.keeps_all || !is_whole(t, map)) {
    retire(t, out);
    return;
  }
  const std::vector<int> sightings = tracks_[t].sightings;
  for (const int s : sightings) detach(s, out);
  remove(t, out);
}

void LandmarkTracks::retire(int t, Contribution& out) {
  undo_.emplace_back([t, at = grid_.middle(t)](LandmarkTracks& all) {
    all.tracks_[t].alive = true;
    ++all.alive_;
    all.grid_.put(t, at[0], at[1]);
  });
  out.forgotten.push_back(t);
  tracks_[t].alive = false;
  --alive_;
  grid_.remove(t);
}

void LandmarkTracks::merge(int from, int into, bool is_3d, Contribution& out) {
  const std::vector<int> moved = tracks_[from].sightings, there = tracks_[into].sightings;
  set(into, &Track::extent, std::max(tracks_[into].extent, tracks_[from].extent));
  for (int s : moved) {
    detach(s, out);
    const bool taken = std::any_of(there.begin(), there.end(), [&](int other) {
      return sightings_[other].frame == sightings_[s].frame;
    });
    if (!taken) attach(s, into, is_3d, out);
  }
  set(into, &Track::existence, std::max(tracks_[into].existence, tracks_[from].existence));
  set(into, &Track::last_keyframe,
      std::max(tracks_[into].last_keyframe, tracks_[from].last_keyframe));
  remove(from, out);
}

void LandmarkTracks::take_handles(const AddedHandles& handles) {
  auto next =
      std::array{handles.continuous.begin(), handles.discrete.begin(), handles.hybrid.begin()};
  for (std::size_t kind = 0; kind < slots_.size(); ++kind) {
    std::vector<Slot>& slots = slots_[kind];
    for (const Slot& slot : slots) {
      const Handle handle = *next[kind]++;
      if (slot.sighting >= 0) sightings_[slot.sighting].factors.push_back(handle);
      if (slot.track >= 0) tracks_[slot.track].prior.push_back(handle);
    }
    slots.clear();
  }
  undo_.clear();
}

void LandmarkTracks::take_back() {
  for (auto step = undo_.rbegin(); step != undo_.rend(); ++step) (*step)(*this);
  undo_.clear();
  for (std::vector<Slot>& slots : slots_) slots.clear();
}

std::vector<double> LandmarkTracks::class_belief(const Track& track,
                                                 const ClassModel& classes) const {
  return posterior(classes.prior(), track.class_evidence);
}

double LandmarkTracks::same_class(int a, int b, const ClassModel& classes) const {
  if (!tracks_[a].class_key) return 0;
  const std::vector<double> p = class_belief(tracks_[a], classes);
  const std::vector<double> q = class_belief(tracks_[b], classes);
  const std::vector<double> prior = classes.prior();
  double sum = 0;
  for (std::size_t s = 0; s < p.size(); ++s) {
    if (prior[s] > 0) sum += p[s] * q[s] / prior[s];
  }
  return std::log(sum);
}

bool LandmarkTracks::seen_times(int t, int times) const {
  auto missing = times - tracks_[t].known_sightings;
  for (int s : tracks_[t].sightings) {
    if (missing <= 0) break;
    const std::size_t n = sightings_[s].detection.members.size();
    missing -= n < kFewestForMotion ? 1 : static_cast<int>(n);
  }
  return missing <= 0;
}

bool LandmarkTracks::is_whole(int t, const MapView& map) const {
  const std::vector<int>& own = tracks_[t].sightings;
  return std::all_of(own.begin(), own.end(), [&](int s) {
    const Sighting& sighting = sightings_[s];
    return sighting.frame == 0 || map.holds(sighting.pose);
  });
}

std::vector<Key> LandmarkTracks::seen_from(int t) const {
  std::vector<Key> poses;
  for (int s : tracks_[t].sightings) poses.push_back(sightings_[s].pose);
  return poses;
}

bool LandmarkTracks::has_id(int t) const {
  const std::vector<int>& own = tracks_[t].sightings;
  return std::any_of(own.begin(), own.end(),
                     [&](int s) { return sightings_[s].detection.id.has_value(); });
}

std::vector<int> LandmarkTracks::sightings_beside(int a, int b, std::size_t at_most) const {
  std::vector<int> beside;
  const auto frame = [this](int s) { return sightings_[s].frame; };
  const std::vector<int>& x = tracks_[a].sightings;
  const std::vector<int>& y = tracks_[b].sightings;
  for (std::size_t i = 0, j = 0; i < x.size() && j < y.size() && beside.size() < at_most;) {
    if (frame(x[i]) == frame(y[j])) beside.push_back(x[i]);
    frame(x[i]) < frame(y[j]) ? ++i : ++j;
  }
  return beside;
}

void LandmarkTracks::place(int t, const Values& values) {
  if (!tracks_[t].alive || !values.contains(tracks_[t].position)) return;
  const double* p = values.data(tracks_[t].position);
  move(t, p[0], p[1]);
}

void LandmarkTracks::move(int t, double x, double y) {
  const std::array<double, 2> before = grid_.middle(t);
  grid_.put(t, x, y);
  if (grid_.middle(t) == before) return;
  undo_.emplace_back([t, before](LandmarkTracks& all) { all.grid_.put(t, before[0], before[1]); });
}

void LandmarkTracks::place_all(const Values& values) {
  for (int t = 0; t < static_cast<int>(tracks_.size()); ++t) place(t, values);
}

void LandmarkTracks::place_some(const Values& values, int count) {
  undo_.emplace_back([next = next_to_place_](LandmarkTracks& all) { all.next_to_place_ = next; });
  for (int i = 0; i < count && !tracks_.empty(); ++i) {
    next_to_place_ = (next_to_place_ + 1) % tracks_.size();
    place(static_cast<int>(next_to_place_), values);
  }
}

}  // namespace hybrid
