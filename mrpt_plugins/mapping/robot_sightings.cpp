// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/robot_sightings.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/factors/robot_sighting.h"

namespace hybrid {
namespace {

SE2 pose_in(const Eigen::Isometry3d& T, const SE2&) {
  return to_se2(T);
}
SE3 pose_in(const Eigen::Isometry3d& T, const SE3&) {
  return to_se3(T);
}

/// Of the position, in the frame of the pose.
template <class Point>
auto position_covariance(const Eigen::Matrix<double, 6, 6>& covariance) {
  constexpr int kDim = Point::RowsAtCompileTime;
  return Eigen::Matrix<double, kDim, kDim>(covariance.topLeftCorner<kDim, kDim>());
}

}  // namespace

void RobotSightings::take(std::size_t observer, Key pose, double time,
                          const std::vector<DetectionFrame>& frames,
                          const std::map<std::int64_t, std::size_t>& robot_of) {
  for (const DetectionFrame& frame : frames) {
    DetectionFrame header = frame;
    header.detections.clear();
    for (const Detection& detection : frame.detections) {
      const auto robot = detection.id ? robot_of.find(*detection.id) : robot_of.end();
      if (robot == robot_of.end()) continue;
      if (robot->second == observer) {
        ++dropped_["robot sighting dropped: of the robot itself"];
        continue;
      }
      waiting_.push_back({robot->second, pose, time, header, detection});
    }
  }
}

/// The robot seen is at a share of its motion. The noise of that is added to that of the sensor,
/// once for each of the `together` sightings that have it in common: R / n + Q is what n sightings
/// tell of one motion, and so are n independent ones of noise R + n Q.
template <class Pose>
ContinuousFactorPtr RobotSightings::factor(const Sighting& s, std::size_t together,
                                           const RobotMotion& motion, const Values& values) const {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  using Matrix = Eigen::Matrix<double, kDim, kDim>;
  const double length = motion.to - motion.from;
  const double share = length > 0 ? std::clamp((s.time - motion.from) / length, 0.0, 1.0) : 0.0;
  const MeasuredPoint measured = measured_point(s.detection, kDim == 3);
  const Pose sensor = pose_in(s.frame.T_robot_sensor, Pose());
  const Pose part = Pose::exp(share * pose_in(motion.motion, Pose()).log());
  const Pose before = values.at<Pose>(motion.before);
  Eigen::Matrix<double, kDim, Pose::kDim> by_observer;
  Matrix by_point;
  SensorView<Pose>(sensor).polar(values.at<Pose>(s.pose), before * part.translation(), &by_observer,
                                 &by_point);
  const Matrix by_offset = by_point * before.rotation().matrix();
  const Matrix moved = static_cast<double>(together) * share *
                       position_covariance<typename Pose::Point>(motion.covariance);
  const Matrix noise = measured.covariance + by_offset * moved * by_offset.transpose();
  return std::make_shared<RobotSighting<Pose>>(s.pose, motion.before, measured.z,
                                               Noise::covariance(noise), sensor, part.translation(),
                                               loss_);
}

std::vector<ContinuousFactorPtr> RobotSightings::met(std::size_t robot, const RobotMotion& motion,
                                                     const Values& values, bool is_3d,
                                                     const std::function<bool(Key)>& held) {
  std::vector<const Sighting*> used;
  const auto rest = std::stable_partition(waiting_.begin(), waiting_.end(), [&](const Sighting& s) {
    return s.seen != robot || s.time > motion.to;
  });
  for (auto s = rest; s != waiting_.end(); ++s) {
    const std::string misfits = misfit(s->frame, is_3d);
    if (!misfits.empty()) {
      ++dropped_["robot sighting dropped: " + misfits];
    } else if (s->time < motion.from) {
      ++dropped_["robot sighting dropped: before the log of that robot"];
    } else if (!held(s->pose) || !held(motion.before)) {
      ++dropped_["robot sighting dropped: its pose is marginalised out"];
    } else {
      used.push_back(&*s);
    }
  }
  std::vector<ContinuousFactorPtr> out;
  for (const Sighting* s : used) {
    out.push_back(is_3d ? factor<SE3>(*s, used.size(), motion, values)
                        : factor<SE2>(*s, used.size(), motion, values));
  }
  used_ += used.size();
  waiting_.erase(rest, waiting_.end());
  return out;
}

void RobotSightings::miss(std::size_t robot, double until) {
  const auto rest = std::stable_partition(waiting_.begin(), waiting_.end(), [&](const Sighting& s) {
    return s.seen != robot || s.time > until;
  });
  const auto count = static_cast<std::size_t>(waiting_.end() - rest);
  if (count > 0) dropped_["robot sighting dropped: no odometry of that robot"] += count;
  waiting_.erase(rest, waiting_.end());
}

std::map<std::string, std::size_t> RobotSightings::dropped() const {
  std::map<std::string, std::size_t> all = dropped_;
  if (!waiting_.empty()) {
    all["robot sighting dropped: after the log of that robot"] += waiting_.size();
  }
  return all;
}

}  // namespace hybrid
