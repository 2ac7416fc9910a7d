// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/count_things.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/spatial_values.h"

namespace hybrid {
namespace {

constexpr int kMostThings = 20;  // that one landmark may stand for

/// How many looks had so many detections of a landmark: looks[0] none, looks[1] one.
using Looks = std::vector<int>;

/// log of the sum of exp(terms).
double log_sum(const std::vector<double>& terms) {
  const double most = *std::max_element(terms.begin(), terms.end());
  double sum = 0;
  for (const double term : terms) sum += std::exp(term - most);
  return most + std::log(sum);
}

/// Probability of so many detections in a look, of `things` that are detected with probability p
/// each, and clutter.
double probability(int detections, int things, double p, double clutter) {
  double sum = 0;
  for (int hits = 0; hits <= std::min(detections, things); ++hits) {
    const int others = detections - hits;
    sum +=
        std::exp(std::lgamma(things + 1) - std::lgamma(hits + 1) - std::lgamma(things - hits + 1) +
                 hits * std::log(p) + (things - hits) * std::log1p(-p) +
                 others * std::log(clutter) - clutter - std::lgamma(others + 1));
  }
  return sum;
}

/// log probability of the looks at so many things: the mean over p.
double log_probability(const Looks& looks, int things, const DetectionModel& detections,
                       double clutter) {
  constexpr int kNodes = 40;
  std::vector<double> terms;
  for (int node = 0; node < kNodes; ++node) {
    const double p = (node + 0.5) / kNodes;
    double term = detections.log_density(p);
    for (std::size_t n = 0; n < looks.size(); ++n) {
      if (looks[n] == 0) continue;
      term += looks[n] * std::log(probability(static_cast<int>(n), things, p, clutter));
    }
    terms.push_back(term);
  }
  return log_sum(terms) - std::log(kNodes);
}

/// Looks from poses that the map holds which had a point well in view, and what they were like in
/// the mean, of whichever sensors.
struct LooksAt {
  int count = 0;
  double detection_probability = 0, space_in_view = 0;
};

LooksAt looks_at(const Eigen::Vector3d& point, const Views& views, const MapView& map,
                 double detection_probability) {
  LooksAt out;
  if (views.empty()) return out;
  const auto add = [&](const SensorCoverage& coverage) {
    out.detection_probability += coverage.detection_probability(detection_probability);
    out.space_in_view += coverage.space_in_view();
  };
  views.visit_near(point, views.reach(), [&](std::size_t view) {
    if (!map.holds(views[view].pose) || !views.covers(view, point, map)) return;
    ++out.count;
    add(views[view].coverage);
  });
  if (out.count == 0) add(views.back().coverage);
  out.detection_probability /= std::max(1, out.count);
  out.space_in_view /= std::max(1, out.count);
  return out;
}

}  // namespace

ThingCounter::ThingCounter(const MapView& map, const ClassModel& classes, const Views& views,
                           const AssociationOptions& options, const LandmarkTracks& landmarks)
    : map_(map),
      views_(views),
      options_(options),
      landmarks_(landmarks),
      costs_(map, classes, landmarks),
      dim_(map.is_3d ? 3 : 2),
      gate_(chi_square_quantile(options.gate, dim_)),
      detections_(landmarks.tracks().size()) {
  std::vector<int> frame;
  const auto& sightings = landmarks.sightings();
  for (int s = 0; s < static_cast<int>(sightings.size()); ++s) {
    if (!frame.empty() && sightings[s].frame != sightings[s - 1].frame) {
      take(frame);
      frame.clear();
    }
    if (map.holds(sightings[s].pose)) frame.push_back(s);
  }
  if (!frame.empty()) take(frame);
}

/// Counts the detections of one look, by number of the sighting.
void ThingCounter::take(const std::vector<int>& sightings) {
  std::map<int, int> detections;  // by track
  for (const int s : sightings) {
    const int t = landmarks_.sighting(s).track;
    if (t >= 0) ++detections[t];
  }
  for (const int s : sightings) {
    const Sighting& sighting = landmarks_.sighting(s);
    if (sighting.track >= 0 || !sighting.detection.may_be_landmark()) continue;
    const int t = nearest(s, detections);
    if (t >= 0) ++detections[t];
  }
  const int frame = landmarks_.sighting(sightings.front()).frame;
  for (const auto& [t, n] : detections) detections_[t][frame] += n;
}

/// The one among some tracks that a detection may be of, by its place and its class; -1: none.
int ThingCounter::nearest(int s, const std::map<int, int>& tracks) const {
  int best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [t, n] : tracks) {
    const GaussianScore score = costs_.place(s, t);
    if (!(score.chi_square <= gate_)) continue;
    const double cost = score.cost + costs_.classes(s, t);
    if (cost >= least) continue;
    least = cost;
    best = t;
  }
  return best;
}

/// The space about a track where detections are counted with it [m^2 or m^3].
double ThingCounter::space_about(int t) const {
  const auto& sightings = landmarks_.track(t).sightings;
  const int last = sightings.back();
  const Eigen::MatrixXd covariance =
      landmarks_
          .located(last, t, isometry_at(map_.values, landmarks_.sighting(last).pose), map_.values,
                   map_.is_3d)
          .covariance.topLeftCorner(dim_, dim_);
  const double ball = dim_ == 3 ? 4.0 / 3 * M_PI : M_PI;
  return ball * std::pow(gate_, 0.5 * dim_) * std::sqrt(covariance.determinant());
}

/// log probability of 1, 2, ... things, up to a common term: up to as many as one look has shown,
/// and `at_least` so many.
std::vector<double> ThingCounter::log_probabilities(const std::vector<int>& tracks,
                                                    int at_least) const {
  std::map<int, int> by_frame;
  for (const int t : tracks) {
    for (const auto& [frame, n] : detections_[t]) by_frame[frame] += n;
  }
  Looks looks(2);
  for (const auto& [frame, n] : by_frame) {
    if (static_cast<int>(looks.size()) <= n) looks.resize(static_cast<std::size_t>(n) + 1);
    ++looks[static_cast<std::size_t>(n)];
  }
  if (at_least <= 1 && looks.size() <= 2) return {0};  // never two at once
  double space = 0;
  for (const int t : tracks) space = std::max(space, space_about(t));
  const Eigen::Vector3d place = point_at(map_.values, landmarks_.track(tracks.front()).position);
  const LooksAt all = looks_at(place, views_, map_, options_.detection_probability);
  looks[0] = std::max(0, all.count - static_cast<int>(by_frame.size()));
  const double clutter = options_.clutter_in_view * space / all.space_in_view;
  const DetectionModel detections(all.detection_probability);
  const int most = std::max(at_least, std::min(kMostThings, static_cast<int>(looks.size()) - 1));
  std::vector<double> out;
  for (int things = 1; things <= most; ++things) {
    out.push_back(log_probability(looks, things, detections, clutter) - (things - 1) * std::log(2));
  }
  return out;
}

int ThingCounter::count(const std::vector<int>& tracks) const {
  const std::vector<double> p = log_probabilities(tracks, 1);
  return 1 + static_cast<int>(std::max_element(p.begin(), p.end()) - p.begin());
}

double ThingCounter::log_odds_of_fewer(const std::vector<int>& tracks) const {
  const auto n = static_cast<int>(tracks.size());
  const std::vector<double> p = log_probabilities(tracks, n);
  return log_sum({p.begin(), p.begin() + n - 1}) - log_sum({p.begin() + n - 1, p.end()});
}

std::map<std::int64_t, LandmarkSize> landmark_sizes(const MapView& map, const ClassModel& classes,
                                                    const Views& views,
                                                    const AssociationOptions& options,
                                                    const LandmarkTracks& landmarks) {
  std::map<std::int64_t, LandmarkSize> out;
  std::optional<ThingCounter> counter;
  if (!views.empty()) counter.emplace(map, classes, views, options, landmarks);
  for (int t = 0; t < static_cast<int>(landmarks.tracks().size()); ++t) {
    const Track& track = landmarks.track(t);
    if (!track.alive) continue;
    const int counted = counter && map.holds(track.position) ? counter->count({t}) : 1;
    out[t] = {track.extent, std::max(counted, track.known_things)};
  }
  return out;
}

}  // namespace hybrid
