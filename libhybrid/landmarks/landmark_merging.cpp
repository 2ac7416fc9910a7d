// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/landmark_merging.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "libhybrid/association/gate.h"
#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/landmarks/count_things.h"

namespace hybrid {
namespace {

/// Pairs that one question compares, the nearest: their joint covariance has a row for each axis of
/// both landmarks, and costs the cube of that.
constexpr std::size_t kMostPairs = 40;

/// Drops the pairs that a new landmark explains better: what takes several landmarks to tell is a
/// loop, which LoopClosing looks for in one place.
void keep_those_alone(IdentityHypotheses& h, double margin) {
  IdentityHypotheses kept;
  kept.dim = h.dim;
  std::vector<Eigen::Index> rows;
  for (std::size_t p = 0; p < h.a.size(); ++p) {
    const Eigen::Index at = h.dim * static_cast<Eigen::Index>(p);
    const GaussianScore score =
        gaussian_score(h.difference.segment(at, h.dim), h.covariance.block(at, at, h.dim, h.dim));
    if (h.gain[p] - score.cost < margin) continue;
    kept.a.push_back(h.a[p]);
    kept.b.push_back(h.b[p]);
    kept.gain.push_back(h.gain[p]);
    for (Eigen::Index k = 0; k < h.dim; ++k) rows.push_back(at + k);
  }
  kept.difference = h.difference(rows);
  kept.covariance = h.covariance(rows, rows);
  h = std::move(kept);
}

/// Expected log density of a sighting of its own landmark, in the units of the measurement.
double expected_log_density(int s, const LandmarkTracks& landmarks) {
  const Sighting& sighting = landmarks.sighting(s);
  const Eigen::MatrixXd R =
      measured_point(landmarks.detection_of(s, sighting.track), sighting.sensor->is_3d).covariance;
  return -0.5 * (std::log((2 * M_PI * R).determinant()) + static_cast<double>(R.rows()));
}

/// log evidence that the sightings of one of two landmarks, where both were seen at a time, are
/// clutter rather than sightings of a landmark.
double clutter_beside(int a, int b, double clutter_density, const LandmarkTracks& landmarks) {
  double sum = 0;
  for (const int s : landmarks.sightings_beside(a, b)) {
    sum += std::log(clutter_density) - expected_log_density(s, landmarks);
  }
  return sum;
}

/// Whether the stretches of the way that two landmarks were seen on do not overlap.
bool are_apart(int a, int b, const LandmarkTracks& landmarks) {
  return landmarks.last_seen_from(a) < landmarks.first_seen_from(b) ||
         landmarks.last_seen_from(b) < landmarks.first_seen_from(a);
}

/// Mean variance of where the detections of a landmark put it, along an axis [m^2].
double detection_variance(int t, const LandmarkTracks& landmarks) {
  double sum = 0;
  const std::vector<int>& own = landmarks.track(t).sightings;
  for (const int s : own) {
    const bool is_3d = landmarks.sighting(s).sensor->is_3d;
    sum += std::pow(position_sigma(landmarks.detection_of(s, t), is_3d), 2);
  }
  return sum / static_cast<double>(own.size());
}

/// By how much less the sightings of a landmark fit another one [nats].
struct MoveCost {
  double places = std::numeric_limits<double>::infinity();
  double classes = 0;
  double sum() const { return places + classes; }
};

MoveCost cost_of_moving(int from, int into, const SightingCosts& costs,
                        const LandmarkTracks& landmarks) {
  MoveCost out{0, 0};
  for (const int s : landmarks.track(from).sightings) {
    out.places += costs.place(s, into).cost - costs.place(s, from).cost;
    out.classes += costs.classes(s, into) - costs.classes(s, from);
  }
  return out;
}

}  // namespace

void LandmarkMerging::sighted(int track, int keyframe, std::size_t n) {
  recent_.set(track, keyframe);
  news_ = news_ || (n & (n - 1)) == 0;  // whenever they have doubled
}

void LandmarkMerging::remember() {
  recent_.commit();
  news_before_ = news_;
}

void LandmarkMerging::take_back() {
  recent_.roll_back();
  news_ = news_before_;
}

void LandmarkMerging::forget(int keyframe) {
  std::vector<int> old;
  for (const auto& [track, last] : recent_.entries()) {
    if (last < keyframe - options_.recent) old.push_back(track);
  }
  for (const int track : old) recent_.erase(track);
}

bool LandmarkMerging::refused(int from, int into, const LandmarkTracks& landmarks) const {
  const auto it = refused_.find({from, into});
  return it != refused_.end() && it->second == landmarks.track(from).sightings.size() +
                                                   landmarks.track(into).sightings.size();
}

void LandmarkMerging::refuse(const Merge& merge, const LandmarkTracks& landmarks) {
  for (const auto& [from, into] : merge.pairs) {
    refused_[{from, into}] =
        landmarks.track(from).sightings.size() + landmarks.track(into).sightings.size();
  }
}

/// Of the landmarks seen since a keyframe with all, or of all with all.
std::vector<LandmarkMerging::Pair> LandmarkMerging::possible_pairs(
    const MapView& map, const ClassModel& classes, double density, std::optional<int> since,
    bool together, const LandmarkTracks& landmarks) const {
  const int dim = map.is_3d ? 3 : 2;
  const double sigmas = std::sqrt(chi_square_quantile(options_.gate, dim));
  // Of what is known less well than landmarks are apart, no pair stands out.
  const double spacing = std::pow(density, -1.0 / dim);
  const auto sigma = [&](const Track& t) { return std::min(spacing, t.sigma); };
  std::vector<Pair> pairs;
  const auto usable = [&](int t) {
    const Track& track = landmarks.track(t);
    return track.alive && map.holds(track.position);
  };
  const auto compare = [&](int t) {
    if (!usable(t)) return;
    const Track& track = landmarks.track(t);
    const Eigen::Vector3d p = point_at(map.values, track.position);
    const double own = sigma(track);
    landmarks.grid().visit_near(p.x(), p.y(), 2 * sigmas * own, [&](int other) {
      if (other >= t || !usable(other)) return;
      const double reach = own + sigma(landmarks.track(other));
      const double d = (point_at(map.values, landmarks.track(other).position) - p).norm();
      if (d > sigmas * reach || refused(t, other, landmarks)) return;
      if (!together && landmarks.seen_together(t, other)) return;
      if (landmarks.same_class(t, other, classes) < -std::log(options_.merge_odds)) return;
      pairs.push_back({t, other, d / reach});
    });
  };
  if (!since) {
    for (int t = 0; t < static_cast<int>(landmarks.tracks().size()); ++t) compare(t);
  } else {
    for (const auto& [t, keyframe] : recent_.entries()) {
      if (keyframe >= *since) compare(t);
    }
  }
  // Where nothing is known yet, nearly all landmarks are pairs: no more are sorted than are kept.
  const auto kept = pairs.begin() + static_cast<std::ptrdiff_t>(std::min(pairs.size(), kMostPairs));
  std::partial_sort(pairs.begin(), kept, pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.distance, a.from, a.into) < std::tie(b.distance, b.from, b.into);
  });
  pairs.erase(kept, pairs.end());
  return pairs;
}

/// The pairs under the joint covariance of all their landmarks.
IdentityHypotheses LandmarkMerging::hypotheses_of(const std::vector<Pair>& pairs,
                                                  const MapView& map, const ClassModel& classes,
                                                  double density, const LandmarkTracks& landmarks) {
  const int dim = map.is_3d ? 3 : 2;
  int columns = 0;
  std::vector<Key> keys;
  const Key seen_from = landmarks.last_seen_from(pairs.front().from);
  if (map.holds(
          seen_from)) {  // for what the joint covariance says of points relative to each other
    keys.push_back(seen_from);
    columns = map.is_3d ? 6 : 3;
  }
  std::map<int, int> column;  // of a track, the first in J
  const auto name = [&](int t) {
    if (!column.emplace(t, columns).second) return;
    keys.push_back(landmarks.track(t).position);
    columns += dim;
  };
  for (const Pair& pair : pairs) {
    name(pair.from);
    name(pair.into);
  }
  IdentityHypotheses h;
  h.dim = dim;
  const int n = static_cast<int>(pairs.size());
  h.difference.resize(dim * n);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(dim * n, columns);
  for (int p = 0; p < n; ++p) {
    h.a.push_back(pairs[p].from);
    h.b.push_back(pairs[p].into);
    h.gain.push_back(-std::log(density) +
                     landmarks.same_class(pairs[p].from, pairs[p].into, classes));
    h.difference.segment(dim * p, dim) =
        (point_at(map.values, landmarks.track(pairs[p].from).position) -
         point_at(map.values, landmarks.track(pairs[p].into).position))
            .head(dim);
    J.block(dim * p, column.at(pairs[p].from), dim, dim).setIdentity();
    J.block(dim * p, column.at(pairs[p].into), dim, dim) = -Eigen::MatrixXd::Identity(dim, dim);
  }
  h.covariance = map.covariance_of(keys, J);
  // Landmarks of many sightings are known better than sensors are calibrated.
  h.covariance.diagonal().array() += 1e-6;
  return h;
}

Merge LandmarkMerging::propose(const MapView& map, const ClassModel& classes, double density,
                               int keyframe, bool everything,
                               const LandmarkTracks& landmarks) const {
  if (!news_ && !everything) return {};
  const std::optional<int> since =
      everything ? std::nullopt : std::optional(keyframe - options_.recent);
  const std::vector<Pair> pairs = possible_pairs(map, classes, density, since, false, landmarks);
  if (pairs.empty()) return {};

  IdentityHypotheses h = hypotheses_of(pairs, map, classes, density, landmarks);
  // The later of the two is one of the landmarks that earlier looks had left undetected there, or
  // it is none of its own.
  for (std::size_t p = 0; p < h.a.size(); ++p) {
    h.gain[p] -= std::log(landmarks.track(h.a[p]).undetected);
  }
  keep_those_alone(h, 0.0);
  const auto n = static_cast<double>(pairs.size());
  if (h.a.empty()) return {};
  // Where there are many pairs to choose from, some agree by chance.
  const double margin = std::log(options_.merge_odds) + std::log(n);
  const ConsensusSet set = decided_consensus(h, options_.gate, margin);
  Merge merge;
  std::set<int> used;
  for (int p : set.pairs) {
    if (used.count(h.a[p]) != 0 || used.count(h.b[p]) != 0) continue;
    used.insert({h.a[p], h.b[p]});
    merge.pairs.emplace_back(h.a[p], h.b[p]);
  }
  if (merge.pairs.empty()) return {};
  merge.evidence = -set.cost;
  merge.chi_square = set.chi_square;
  return merge;
}

Merge LandmarkMerging::propose_by_misses(const MapView& map, const ClassModel& classes,
                                         double density, const Views& views,
                                         const LandmarkTracks& landmarks) const {
  Merge merge;
  if (views.empty()) return merge;
  const std::vector<Pair> pairs =
      possible_pairs(map, classes, density, std::nullopt, true, landmarks);
  if (pairs.empty()) return merge;
  const IdentityHypotheses h = hypotheses_of(pairs, map, classes, density, landmarks);
  const SensorCoverage& coverage = views.back().coverage;
  const DetectionModel detections(coverage.detection_probability(options_.detection_probability));
  const double clutter_density = options_.clutter_in_view / coverage.measurement_volume();
  const auto place = [&](int t) { return point_at(map.values, landmarks.track(t).position); };
  merge.evidence = std::log(options_.merge_odds);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const int a = pairs[p].from, b = pairs[p].into;
    const Eigen::Index at = h.dim * static_cast<Eigen::Index>(p);
    const GaussianScore score =
        gaussian_score(h.difference.segment(at, h.dim), h.covariance.block(at, at, h.dim, h.dim));
    const bool near = score.chi_square <= chi_square_quantile(options_.gate, h.dim);
    if (!near || are_apart(a, b, landmarks) || !may_become_another(a, landmarks) ||
        !is_confirmed(b, landmarks)) {
      continue;
    }
    const double evidence = h.gain[p] - score.cost +
                            clutter_beside(a, b, clutter_density, landmarks) +
                            views.one_rather_than_two(place(a), landmarks.seen_from(a), place(b),
                                                      landmarks.seen_from(b), detections, map);
    if (evidence <= merge.evidence) continue;
    merge = {{{a, b}}, evidence, score.chi_square, false};
  }
  return merge;
}

bool LandmarkMerging::is_confirmed(int t, const LandmarkTracks& landmarks) const {
  return landmarks.seen_times(t, options_.confirm) && landmarks.track(t).existence > 0;
}

/// Not one that is named by its id, or was known before the first keyframe.
bool LandmarkMerging::may_become_another(int t, const LandmarkTracks& landmarks) const {
  return is_confirmed(t, landmarks) && landmarks.track(t).known_sightings == 0 &&
         !(options_.use_ids && landmarks.has_id(t));
}

/// Landmarks among which the place of the usual detection does not decide whose it is, by
/// neighbours.
std::vector<std::vector<int>> LandmarkMerging::places(const MapView& map,
                                                      const LandmarkTracks& landmarks) const {
  const auto n = static_cast<int>(landmarks.tracks().size());
  std::vector<double> variance(n, 0.0);  // 0: not asked about
  for (int t = 0; t < n; ++t) {
    const Track& track = landmarks.track(t);
    const bool asked = track.alive && map.holds(track.position) && landmarks.is_whole(t, map) &&
                       may_become_another(t, landmarks);
    if (asked) variance[t] = detection_variance(t, landmarks);
  }
  const auto point = [&](int t) { return point_at(map.values, landmarks.track(t).position); };
  const auto may_be_one = [&](int a, int b) {
    const double chi_square = (point(a) - point(b)).squaredNorm() / (variance[a] + variance[b]);
    return chi_square <= std::log(options_.merge_odds) && !are_apart(a, b, landmarks) &&
           !refused(a, b, landmarks) && !refused(b, a, landmarks);
  };
  std::vector<std::vector<int>> out;
  std::vector<bool> taken(n, false);
  for (int first = 0; first < n; ++first) {
    if (taken[first] || variance[first] == 0) continue;
    std::vector<int> place = {first};
    taken[first] = true;
    for (std::size_t k = 0; k < place.size(); ++k) {
      const int t = place[k];
      const double radius = std::sqrt(8 * variance[t] * std::log(options_.merge_odds));
      landmarks.grid().visit_near(point(t).x(), point(t).y(), radius, [&](int other) {
        if (taken[other] || variance[other] == 0 || !may_be_one(t, other)) return;
        taken[other] = true;
        place.push_back(other);
      });
    }
    if (place.size() > 1) out.push_back(std::move(place));
  }
  return out;
}

Merge LandmarkMerging::propose_by_counting(const MapView& map, const ClassModel& classes,
                                           const Views& views,
                                           const LandmarkTracks& landmarks) const {
  Merge merge;
  const auto all = places(map, landmarks);
  if (views.empty() || all.empty()) return merge;
  const ThingCounter counter(map, classes, views, options_, landmarks);
  const SightingCosts costs(map, classes, landmarks);
  for (const std::vector<int>& place : all) {
    std::pair<int, int> spared;
    MoveCost least;
    for (const int from : place) {
      for (const int into : place) {
        if (from == into || refused(from, into, landmarks)) continue;
        const MoveCost cost = cost_of_moving(from, into, costs, landmarks);
        if (!(cost.sum() < least.sum())) continue;
        least = cost;
        spared = {from, into};
      }
    }
    const double evidence = counter.log_odds_of_fewer(place) - least.classes;
    if (std::isinf(least.places) || !(evidence > std::log(options_.merge_odds))) continue;
    merge.pairs.push_back(spared);
    merge.evidence += evidence;
    merge.chi_square += 2 * std::max(0.0, least.sum());
  }
  return merge;
}

}  // namespace hybrid
