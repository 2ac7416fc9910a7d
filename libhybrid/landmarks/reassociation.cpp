// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/reassociation.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "libhybrid/association/matching.h"
#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/landmarks/sighting_costs.h"

namespace hybrid {
namespace {

/// Decrease of cost that is not rounding.
constexpr double kLeastGain = 1e-6;

/// The frames of a map, one at a time.
class FrameMatcher {
 public:
  FrameMatcher(const MapView& map, const ClassModel& classes, const AssociationOptions& options,
               const LandmarkTracks& landmarks)
      : map_(map),
        landmarks_(landmarks),
        costs_(map, classes, landmarks),
        confirm_(options.confirm),
        gate_(chi_square_quantile(options.gate, map.is_3d ? 3 : 2)) {}

  /// What is better otherwise of the sightings of one frame.
  void match(const std::vector<int>& sightings, double clutter_density,
             std::vector<Reassignment>& out) {
    const std::vector<int> tracks = candidates(sightings);
    if (tracks.empty()) return;
    const auto rows = static_cast<Eigen::Index>(sightings.size());
    const auto cols = static_cast<Eigen::Index>(tracks.size());
    MatchingProblem problem;
    problem.matched.setConstant(rows, cols, kInfinity);
    problem.unmatched.resize(rows);
    double now = 0;
    for (Eigen::Index i = 0; i < rows; ++i) {
      const int track = landmarks_.sighting(sightings[i]).track;
      problem.unmatched[i] = clutter_cost(sightings[i], clutter_density);
      for (Eigen::Index j = 0; j < cols; ++j) {
        const bool own = tracks[j] == track;
        const double cost = pair_cost(sightings[i], tracks[j], own);
        problem.matched(i, j) = cost;
        if (own) now += cost;
      }
      if (track < 0) now += problem.unmatched[i];
    }
    const Matching best = best_matching(problem);
    if (!(best.cost < now - kLeastGain)) return;
    for (std::size_t i = 0; i < sightings.size(); ++i) {
      const int track = best.column[i] < 0 ? -1 : tracks[best.column[i]];
      if (track != landmarks_.sighting(sightings[i]).track) out.push_back({sightings[i], track});
    }
  }

  /// What a sighting gains by being of the track that its id names and no clutter; 0: no track.
  double gain_of_named(int s, int named, double clutter_density) {
    if (!landmarks_.track(named).alive || !map_.holds(landmarks_.track(named).position)) return 0;
    return clutter_cost(s, clutter_density) - pair_cost(s, named, true);
  }

 private:
  /// The landmarks that the sightings may be of: those near where they fall, and their own.
  std::vector<int> candidates(const std::vector<int>& sightings) const {
    std::set<int> tracks;
    for (int s : sightings) {
      const Sighting& sighting = landmarks_.sighting(s);
      if (sighting.track >= 0) tracks.insert(sighting.track);
      const PointSighting seen = landmarks_.located(s, -1, isometry_at(map_.values, sighting.pose),
                                                    map_.values, map_.is_3d);
      const double radius = std::sqrt(gate_ * seen.covariance.trace());
      landmarks_.grid().visit_near(seen.point.x(), seen.point.y(), radius, [&](int t) {
        const Track& track = landmarks_.track(t);
        const bool confirmed = landmarks_.seen_times(t, confirm_) && track.existence > 0;
        if (track.alive && confirmed && map_.holds(track.position)) tracks.insert(t);
      });
    }
    return {tracks.begin(), tracks.end()};
  }

  /// -log p of a sighting that is clutter.
  double clutter_cost(int s, double density) const {
    return -std::log(density) + costs_.unknown_classes(s);
  }

  /// -log p of a sighting of this track; its present one is not gated.
  double pair_cost(int s, int t, bool own) const {
    const GaussianScore score = costs_.place(s, t);
    if (!own && score.chi_square > gate_) return kInfinity;
    return score.cost + costs_.classes(s, t);
  }

  const MapView& map_;
  const LandmarkTracks& landmarks_;
  SightingCosts costs_;
  int confirm_;
  double gate_;
};

}  // namespace

std::vector<Reassignment> reassociate(const MapView& map, const ClassModel& classes,
                                      const std::map<std::string, SensorCoverage>& coverage,
                                      const AssociationOptions& options,
                                      const std::map<std::int64_t, int>& track_of_id,
                                      const LandmarkTracks& landmarks) {
  FrameMatcher matcher(map, classes, options, landmarks);
  std::vector<Reassignment> out;
  std::vector<int> frame;
  std::map<int, std::vector<std::pair<double, int>>> misread;  // track -> gains, sightings
  const auto clutter_density = [&](int s) {
    const SensorCoverage& sensor = coverage.at(landmarks.sighting(s).sensor->sensor_label);
    return options.clutter_in_view / sensor.measurement_volume();
  };
  const auto finish_frame = [&] {
    if (!frame.empty()) matcher.match(frame, clutter_density(frame.front()), out);
    frame.clear();
  };
  const auto count = static_cast<int>(landmarks.sightings().size());
  for (int s = 0; s < count; ++s) {
    const Sighting& sighting = landmarks.sighting(s);
    if (s > 0 && sighting.frame != landmarks.sighting(s - 1).frame) finish_frame();
    const Detection& seen = sighting.detection;
    if (!seen.may_be_landmark() || !map.holds(sighting.pose)) continue;
    if (options.use_ids && sighting.detection.id) {
      const auto named = track_of_id.find(*sighting.detection.id);
      if (named == track_of_id.end()) continue;
      const double gain = matcher.gain_of_named(s, named->second, clutter_density(s));
      if (sighting.track < 0 && gain > kLeastGain) out.push_back({s, named->second});
      if (sighting.track == named->second && gain < -kLeastGain) {
        misread[named->second].emplace_back(gain, s);
      }
    } else {
      frame.push_back(s);
    }
  }
  finish_frame();
  // Where a few are far off, none may fit: the worse half goes, the others are asked again.
  for (auto& [t, sightings] : misread) {
    std::sort(sightings.begin(), sightings.end());
    const std::size_t half = landmarks.track(t).sightings.size() / 2;
    for (std::size_t i = 0; i < std::min(half, sightings.size()); ++i) {
      out.push_back({sightings[i].second, -1});
    }
  }
  return out;
}

}  // namespace hybrid
