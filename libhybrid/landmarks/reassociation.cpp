// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/reassociation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "libhybrid/association/gate.h"
#include "libhybrid/association/matching.h"
#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/landmarks/detail/sensor_place.h"
#include "libhybrid/landmarks/sighting.h"

namespace hybrid {
namespace {

/// Decrease of cost that is not rounding.
constexpr double kLeastGain = 1e-6;

/// The frames of a map, one at a time.
class FrameMatcher {
 public:
  FrameMatcher(const MapView& map, const ClassModel& classes, const AssociationOptions& options,
               const LandmarkTracks& landmarks)
      : map_(map), classes_(classes), landmarks_(landmarks), dim_(map.is_3d ? 3 : 2) {
    confirm_ = options.confirm;
    gate_ = chi_square_quantile(options.gate, dim_);
    if (classes.names().size() > 1) prior_ = classes.prior();
  }

  /// What is better otherwise of the sightings of one frame.
  void match(const std::vector<int>& sightings, double clutter_density,
             std::vector<Reassignment>& out) {
    T_map_sensor_ = sensor_pose(landmarks_.sighting(sightings.front()));
    const std::vector<int> tracks = candidates(sightings);
    if (tracks.empty()) return;
    const auto rows = static_cast<Eigen::Index>(sightings.size());
    const auto cols = static_cast<Eigen::Index>(tracks.size());
    MatchingProblem problem;
    problem.matched.setConstant(rows, cols, std::numeric_limits<double>::infinity());
    problem.unmatched.resize(rows);
    double now = 0;
    for (Eigen::Index i = 0; i < rows; ++i) {
      const Sighting& sighting = landmarks_.sighting(sightings[i]);
      problem.unmatched[i] = -std::log(clutter_density) + class_cost(sighting.phi, prior_);
      for (Eigen::Index j = 0; j < cols; ++j) {
        const bool own = tracks[j] == sighting.track;
        const double cost = pair_cost(sightings[i], tracks[j], own);
        problem.matched(i, j) = cost;
        if (own) now += cost;
      }
      if (sighting.track < 0) now += problem.unmatched[i];
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
    const Sighting& sighting = landmarks_.sighting(s);
    if (!landmarks_.track(named).alive || !map_.holds(landmarks_.track(named).position)) return 0;
    T_map_sensor_ = sensor_pose(sighting);
    const double clutter = -std::log(clutter_density) + class_cost(sighting.phi, prior_);
    return clutter - pair_cost(s, named, true);
  }

 private:
  Eigen::Isometry3d sensor_pose(const Sighting& sighting) const {
    const Eigen::Isometry3d T_map_sensor = compose(isometry_at(map_.values, sighting.pose),
                                                   sensor_place(*sighting.sensor, map_.values));
    return map_.is_3d ? T_map_sensor : to_isometry(to_se2(T_map_sensor));
  }

  /// The landmarks that the sightings may be of: those near where they fall, and their own.
  std::vector<int> candidates(const std::vector<int>& sightings) const {
    std::set<int> tracks;
    for (int s : sightings) {
      const Sighting& sighting = landmarks_.sighting(s);
      if (sighting.track >= 0) tracks.insert(sighting.track);
      const Detection d = landmarks_.detection_of(s, -1);
      const Eigen::Vector3d point =
          T_map_sensor_ * from_polar(Eigen::Vector3d(d.range, d.yaw, d.pitch));
      const double angle = std::max(d.covariance(1, 1), d.covariance(2, 2));
      const double radius =
          std::sqrt(gate_ * std::max(d.covariance(0, 0), d.range * d.range * angle));
      landmarks_.grid().visit_near(point.x(), point.y(), radius, [&](int t) {
        const Track& track = landmarks_.track(t);
        const bool confirmed = landmarks_.seen_times(t, confirm_) && track.existence > 0;
        if (track.alive && confirmed && map_.holds(track.position)) tracks.insert(t);
      });
    }
    return {tracks.begin(), tracks.end()};
  }

  /// -log p of a sighting of this track; its present one is not gated.
  double pair_cost(int s, int t, bool own) const {
    const Sighting& sighting = landmarks_.sighting(s);
    const Track& track = landmarks_.track(t);
    const Detection d = landmarks_.detection_of(s, t);
    const Eigen::Vector3d seen = to_polar(
        Eigen::Vector3d(T_map_sensor_.linear().transpose() *
                        (point_at(map_.values, track.position) - T_map_sensor_.translation())));
    const MeasuredPoint measured = measured_point(d, dim_ == 3);
    Eigen::VectorXd v = measured.z - seen.head(dim_);
    v[1] = wrap_angle(v[1]);
    const GaussianScore score = gaussian_score(v, measured.covariance);
    if (!own && score.chi_square > gate_) return std::numeric_limits<double>::infinity();
    if (!track.class_key) return score.cost;
    return score.cost + class_cost(sighting.phi, landmarks_.class_belief(track, classes_));
  }

  const MapView& map_;
  const ClassModel& classes_;
  const LandmarkTracks& landmarks_;
  int dim_;
  int confirm_ = 0;
  double gate_ = 0;
  std::vector<double> prior_;  // of the classes
  Eigen::Isometry3d T_map_sensor_ = Eigen::Isometry3d::Identity();
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
