// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/landmark_mapper.h"

#include <memory>
#include <type_traits>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/motion_covariance.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/geometry/isometry.h"

namespace hybrid {

template <class Pose>
Key LandmarkMapper<Pose>::pose_key(std::size_t i) {
  return {key_letter::kPose, i};
}

template <class Pose>
MapView LandmarkMapper<Pose>::view() const {
  MapView map{smoother_.values(), smoother_.assignment(), landmarks_, std::is_same_v<Pose, SE3>};
  map.holds = [this](Key key) { return smoother_.values().contains(key); };
  map.joint_covariance = [this](const std::vector<Key>& keys) {
    return smoother_.joint_covariance(keys);
  };
  map.covariance_of = [this](const std::vector<Key>& keys, const Eigen::MatrixXd& J) {
    return smoother_.joint_covariance(keys, J);
  };
  return map;
}

template <class Pose>
bool LandmarkMapper<Pose>::add(const Pose& motion, const Noise& noise,
                               const std::vector<DetectionFrame>& detections) {
  const Key now = pose_key(keyframes_);
  Pose T_map_robot = motion;
  ContinuousFactorPtr factor;
  if (keyframes_ == 0) {
    factor = std::make_shared<Prior<Pose>>(now, motion, noise);
  } else {
    const Key before = pose_key(keyframes_ - 1);
    T_map_robot = smoother_.values().template at<Pose>(before) * motion;
    factor = std::make_shared<Between<Pose>>(before, now, motion, noise);
  }
  Delta delta;
  delta.continuous.push_back(factor);
  delta.values.insert(now, T_map_robot);
  const MapView map = view();
  KeyframeView frame{now, to_isometry(T_map_robot), detections};
  const MotionCovariance after(*factor, now, delta.values, smoother_.values(), map.covariance_of);
  frame.joint_covariance = after;
  frame.covariance_of = after;
  Contribution contribution;
  try {
    contribution = association_.observe(frame, map);
  } catch (...) {
    association_.refused();
    throw;
  }
  const bool used = apply(contribution, delta) == UpdateReport::Status::kOk;
  if (!used) smoother_.update(delta);
  ++keyframes_;
  revise(false);
  return used;
}

/// One update with a contribution and the motion to a new pose, if there is one.
template <class Pose>
UpdateReport::Status LandmarkMapper<Pose>::apply(const Contribution& contribution,
                                                 const Delta& motion) {
  Delta delta = contribution.delta;
  const std::size_t own = delta.continuous.size();
  delta.continuous.insert(delta.continuous.end(), motion.continuous.begin(),
                          motion.continuous.end());
  for (const Key key : motion.values.keys()) {
    delta.values.insert(key, motion.values.type(key), motion.values.data(key));
  }
  const double before = smoother_.objective();
  UpdateReport report;
  try {
    enter(contribution, landmarks_);
    report =
        contribution.allowed_rise
            ? propose(smoother_, {std::move(delta), *contribution.allowed_rise, contribution.moved})
            : smoother_.update(delta);
  } catch (...) {
    landmarks_.roll_back();
    association_.refused();
    throw;
  }
  if (report.status != UpdateReport::Status::kOk) {
    landmarks_.roll_back();
    association_.refused();
    return report.status;
  }
  landmarks_.commit();
  if (contribution.settle) smoother_.settle();
  report.handles.continuous.resize(own);  // those of the motion come behind
  association_.applied({report.handles, before, smoother_.objective(), report.exact});
  return report.status;
}

template <class Pose>
void LandmarkMapper<Pose>::revise(bool concluding) {
  for (bool again = true; again;) {
    const MapView map = view();
    const Contribution change = concluding ? association_.conclude(map) : association_.revise(map);
    again = !change.empty() && apply(change, {}) != UpdateReport::Status::kSingular;
  }
}

template <class Pose>
void LandmarkMapper<Pose>::finish() {
  revise(true);
  smoother_.converge();
}

template class LandmarkMapper<SE2>;
template class LandmarkMapper<SE3>;

}  // namespace hybrid
