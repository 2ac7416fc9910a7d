// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/detail/convert_object.h"

#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <Eigen/Geometry>
#include <optional>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/mrpt_version.h"

namespace hybrid {
namespace {

using mrpt::maps::CPointsMap;
using mrpt::maps::CSimpleMap;
using mrpt::maps::CSimplePointsMap;
using mrpt::math::TPoint3Df;
using mrpt::obs::CActionCollection;
using mrpt::obs::CActionRobotMovement2D;
using mrpt::obs::CActionRobotMovement3D;
using mrpt::obs::CObservation;
using mrpt::obs::CSensoryFrame;

/// All points of a scan, without thinning, seen from the robot.
std::vector<TPoint3Df> inserted_points(const CObservation& observation) {
  CSimplePointsMap map;
  map.insertionOptions.minDistBetweenLaserPoints = 0;
  keep_all_points(map.insertionOptions);
  map.insertObservation(observation);
  return points_of(map);
}

LoggedObservation convert(const CObservation::Ptr& observation, bool points) {
  if (!observation) throw Error("an observation is missing");
  LoggedObservation out;
  out.class_name = observation->GetRuntimeClass()->className;
  out.time = observation->timestamp;
  out.content = observation;
  if (points) out.points = inserted_points(*observation);
  return out;
}

LoggedMotion motion_in(const CActionCollection& actions) {
  for (const auto& action : actions) {
    if (const auto* motion = dynamic_cast<const CActionRobotMovement3D*>(action.get())) {
      return motion->poseChange;
    }
  }
  for (const auto& action : actions) {
    const auto* motion = dynamic_cast<const CActionRobotMovement2D*>(action.get());
    if (motion == nullptr || !motion->poseChange) continue;
    const auto [covariance, mean] = motion->poseChange->getCovarianceAndMean();
    return mrpt::poses::CPosePDFGaussian(mean, covariance);
  }
  return std::monostate();
}

LogObject convert(const CActionCollection& actions) {
  LoggedActions out;
  const auto first = actions.begin();
  if (first != actions.end() && first->get() != nullptr) out.time = first->get()->timestamp;
  out.motion = motion_in(actions);
  return out;
}

/// A motion between keyframes, whose errors nobody states.
mrpt::poses::CPose3DPDFGaussian with_usual_errors(const mrpt::poses::CPose3D& motion) {
  const Eigen::Matrix3d R = motion.getRotationMatrix().asEigen();
  return pose_pdf(motion, usual_motion_covariance(motion.norm(), Eigen::AngleAxisd(R).angle()));
}

LogObject convert(const CSensoryFrame& frame, bool points) {
  LoggedFrame out;
  for (const CObservation::Ptr& entry : frame) out.observations.push_back(convert(entry, points));
  return out;
}

}  // namespace

std::vector<TPoint3Df> points_of(const CPointsMap& map) {
  std::vector<float> x, y, z;
  map.getAllPoints(x, y, z);
  std::vector<TPoint3Df> points;
  points.reserve(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) points.emplace_back(x[i], y[i], z[i]);
  return points;
}

std::vector<LogObject> keyframes_of(const CSimpleMap& map) {
  std::vector<LogObject> out;
  std::optional<mrpt::poses::CPose3D> before;
  for (std::size_t i = 0; i < map.size(); ++i) {
    mrpt::poses::CPose3DPDF::ConstPtr known;
    CSensoryFrame::ConstPtr seen;
    map.get(i, known, seen);
    if (!known || !seen) throw Error("a keyframe of a simple map is missing");
    const mrpt::poses::CPose3D pose = known->getMeanVal();
    if (before) {
      LoggedActions actions;
      if (!seen->empty() && *seen->begin()) actions.time = (*seen->begin())->timestamp;
      actions.motion = with_usual_errors(pose - *before);
      out.emplace_back(std::move(actions));
    }
    before = pose;
    out.push_back(convert(*seen, false));
  }
  return out;
}

LogObject convert_object(const mrpt::serialization::CSerializable::Ptr& object, bool points) {
  if (!object) throw Error("an object is missing");
  if (const auto* actions = dynamic_cast<const CActionCollection*>(object.get())) {
    return convert(*actions);
  }
  if (const auto* frame = dynamic_cast<const CSensoryFrame*>(object.get())) {
    return convert(*frame, points);
  }
  if (const auto observation = std::dynamic_pointer_cast<CObservation>(object)) {
    return convert(observation, points);
  }
  if (const auto* map = dynamic_cast<const CPointsMap*>(object.get()); map && points) {
    return LoggedPoints{points_of(*map)};
  }
  if (const auto* map = dynamic_cast<const CSimpleMap*>(object.get()); map && points) {
    CSimplePointsMap all;
    all.loadFromSimpleMap(*map);
    return LoggedPoints{points_of(all)};
  }
  return OtherObject{object->GetRuntimeClass()->className};
}

}  // namespace hybrid
