// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// The third part of the class: things that move.

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/landmarks/landmark_association.h"
#include "libhybrid/landmarks/sighting.h"

namespace hybrid {
namespace {

/// The covariance that a point of the map has from that of the pose it was seen from.
Eigen::Matrix3d from_pose(const Eigen::Vector3d& point, const Eigen::Isometry3d& T_map_robot,
                          const Eigen::MatrixXd& covariance, bool is_3d) {
  const Eigen::Matrix3d R = T_map_robot.linear();
  const Eigen::Vector3d q = R.transpose() * (point - T_map_robot.translation());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, is_3d ? 6 : 3);
  if (is_3d) {
    J.leftCols<3>().setIdentity();
    J.rightCols<3>() << 0, q.z(), -q.y(), -q.z(), 0, q.x(), q.y(), -q.x(), 0;
  } else {
    J.topLeftCorner<2, 2>().setIdentity();
    J.col(2) << -q.y(), q.x(), 0;
  }
  return R * (J * covariance * J.transpose()) * R.transpose();
}

}  // namespace

/// By the map, and by `frame` what was seen from its pose, which the map does not have yet.
ThingTracker::Locate LandmarkAssociation::locate(const MapView& map,
                                                 const KeyframeView* frame) const {
  return [this, &map, frame](int s) {
    const Sighting& sighting = landmarks_.sighting(s);
    const bool is_new = frame != nullptr && sighting.pose == frame->pose;
    return point_sighting(is_new ? frame->T_map_robot : isometry_at(map.values, sighting.pose),
                          *sighting.sensor, landmarks_.detection_of(s, -1), map.is_3d);
  };
}

/// Follows the things of a frame, and marks the sightings of those that move.
void LandmarkAssociation::follow(const std::vector<int>& noted, const KeyframeView& frame,
                                 const SensorCoverage& coverage, const MapView& map) {
  if (!things_.is_on() || noted.empty()) return;
  const bool is_next = now_.followed_from && *now_.followed_from != frame.pose;
  if (is_next) now_.since_followed = covariance_of_motion(frame, *now_.followed_from, map);
  std::vector<ThingSighting> seen;
  for (const int s : noted) {
    const Sighting& sighting = landmarks_.sighting(s);
    ThingSighting thing{s,
                        point_sighting(frame.T_map_robot, *sighting.sensor,
                                       landmarks_.detection_of(s, -1), map.is_3d),
                        {},
                        sighting.phi};
    if (options_.use_ids) thing.id = sighting.detection.id;
    if (now_.since_followed.size() > 0) {
      thing.seen.covariance +=
          from_pose(thing.seen.point, frame.T_map_robot, now_.since_followed, map.is_3d);
    }
    seen.push_back(std::move(thing));
  }
  ThingTracker::Look look{coverage.detection_probability(options_.detection_probability),
                          coverage.space_in_view(),
                          map.is_3d,
                          {}};
  if (now_.classes.names().size() > 1) look.class_prior = now_.classes.prior();
  things_.take(seen, look, locate(map, &frame));
  now_.followed_from = frame.pose;
  for (const int s : noted) landmarks_.sighting(s).detection.moving = things_.moves(s);
}

/// Takes the sightings of things that turned out to move from their landmarks. What is undecided
/// of a frame, and of a landmark with undecided sightings, waits for the decision.
void LandmarkAssociation::withdraw_movers(const MapView& map, Contribution& out) {
  std::set<int> undecided, emptied;
  for (const OpenFrame& open : now_.open) {
    undecided.insert(open.sightings.begin(), open.sightings.end());
  }
  for (const int s : things_.take_changed()) {
    Sighting& sighting = landmarks_.sighting(s);
    sighting.detection.moving = things_.moves(s);
    to_withdraw_.insert(s);
  }
  std::set<int> waiting;
  for (const int s : to_withdraw_) {
    const Sighting& sighting = landmarks_.sighting(s);
    const int t = sighting.track;
    if (!sighting.detection.moving || t < 0 || !map.keeps_all || !map.holds(sighting.pose))
      continue;
    waiting.insert(s);  // until it is seen to be done
    if (undecided.count(s) != 0 || landmarks_.track(t).open > 0) continue;
    landmarks_.detach(s, out);
    ++out.dropped[kMoving];
    if (map.explain) out.events.decisions.push_back({s, std::nullopt, true});
    if (landmarks_.track(t).sightings.empty()) emptied.insert(t);
  }
  to_withdraw_ = std::move(waiting);
  for (const int t : emptied) landmarks_.remove(t, out);
}

std::vector<Mover> LandmarkAssociation::movers(const std::vector<double>& times,
                                               const MapView& map) const {
  return things_.movers(times, locate(map));
}

}  // namespace hybrid
