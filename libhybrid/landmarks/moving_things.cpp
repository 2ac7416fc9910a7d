// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/moving_things.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/geometry/isometry.h"

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
ThingTracker::Locate MovingThings::locate(const MapView& map, const LandmarkTracks& landmarks,
                                          const KeyframeView* frame) {
  return [&map, &landmarks, frame](int s) {
    const Key pose = landmarks.sighting(s).pose;
    const bool is_new = frame != nullptr && pose == frame->pose;
    return landmarks.located(s, -1, is_new ? frame->T_map_robot : isometry_at(map.values, pose),
                             map.values, map.is_3d);
  };
}

void MovingThings::take(const std::vector<int>& noted, const KeyframeView& frame,
                        const SensorCoverage& coverage, const ClassModel& classes,
                        const MapView& map, LandmarkTracks& landmarks) {
  now_.is_decided = false;
  if (!things_.is_on() || noted.empty()) return;
  if (now_.pose && *now_.pose != frame.pose) {
    now_.motion = covariance_of_motion(frame, *now_.pose, map);
  }
  const ThingTracker::Locate located = locate(map, landmarks, &frame);
  std::vector<ThingSighting> seen;
  for (const int s : noted) {
    const Sighting& sighting = landmarks.sighting(s);
    ThingSighting thing{s, located(s), {}, sighting.phi};
    if (options_.use_ids) thing.id = sighting.detection.id;
    if (now_.motion.size() > 0) {
      thing.seen.covariance +=
          from_pose(thing.seen.point, frame.T_map_robot, now_.motion, map.is_3d);
    }
    seen.push_back(std::move(thing));
  }
  ThingTracker::Look look{coverage.detection_probability(options_.detection_probability),
                          coverage.space_in_view(),
                          map.is_3d,
                          {}};
  if (classes.names().size() > 1) look.class_prior = classes.prior();
  things_.take(seen, look, located);
  now_.pose = frame.pose;
  for (const int s : noted) landmarks.sighting(s).detection.moving = things_.moves(s);
}

void MovingThings::decide(const MapView& map, const LandmarkTracks& landmarks) {
  if (!now_.is_decided) things_.decide(locate(map, landmarks));
  now_.is_decided = true;
}

void MovingThings::withdraw(const std::set<int>& undecided, const MapView& map,
                            LandmarkTracks& landmarks, Contribution& out) {
  for (const int s : things_.take_changed()) {
    landmarks.sighting(s).detection.moving = things_.moves(s);
    to_withdraw_.insert(s);
  }
  std::set<int> waiting, emptied;
  for (const int s : to_withdraw_) {
    const Sighting& sighting = landmarks.sighting(s);
    const int t = sighting.track;
    if (!sighting.detection.moving || t < 0 || !map.keeps_all || !map.holds(sighting.pose))
      continue;
    waiting.insert(s);  // until it is seen to be done
    if (undecided.count(s) != 0 || landmarks.track(t).open > 0) continue;
    landmarks.detach(s, out);
    ++out.dropped[kDropped];
    if (map.explain) out.events.decisions.push_back({s, std::nullopt, true});
    if (landmarks.track(t).sightings.empty()) emptied.insert(t);
  }
  to_withdraw_ = std::move(waiting);
  for (const int t : emptied) landmarks.remove(t, out);
}

void MovingThings::remember() {
  before_ = now_;
  things_.remember();
}

void MovingThings::take_back() {
  now_ = before_;
  things_.take_back();
}

}  // namespace hybrid
