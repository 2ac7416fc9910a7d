// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_mapper.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"

namespace hybrid {
namespace {

constexpr double kOrigin = 1e-3;  // m, rad: sigma of the first pose, which is the frame
/// Sigma of a motion that nothing tells [reach], [rad].
constexpr double kUntoldTranslation = 1;
constexpr double kUntoldRotation = 1;

Key pose_key(std::size_t cloud) {
  return {key_letter::kPose, cloud};
}

ContinuousFactorPtr motion_factor(std::size_t from, std::size_t to,
                                  const UncertainMotion3& motion) {
  return std::make_shared<Between<SE3>>(pose_key(from), pose_key(to), motion.motion,
                                        Noise::covariance(motion.covariance));
}

/// The motion to a cloud from the one before: what a match, and odometry where it is known, tell; a
/// motion that is hardly known where none of them does.
std::vector<UncertainMotion3> motions_to(const TrackedCloud& tracked,
                                         const std::optional<UncertainMotion3>& odometry,
                                         double reach) {
  std::vector<UncertainMotion3> out;
  if (tracked.match) out.push_back(tracked.match->measured);
  if (odometry) out.push_back(*odometry);
  if (!out.empty()) return out;
  Eigen::Matrix<double, 6, 1> sigmas;
  sigmas << Eigen::Vector3d::Constant(kUntoldTranslation * std::max(reach, 1.0)),
      Eigen::Vector3d::Constant(kUntoldRotation);
  out.push_back({tracked.T_before_cloud, sigmas.cwiseAbs2().asDiagonal()});
  return out;
}

}  // namespace

CloudMapper::CloudMapper(const CloudMapperOptions& options)
    : tracker_(options.tracker), search_(options.closures), selection_(options.selection) {}

SE3 CloudMapper::pose(std::size_t cloud) const {
  return selection_.smoother().values().at<SE3>(pose_key(cloud));
}

UncertainMotion3 CloudMapper::relation(std::size_t a, std::size_t b) const {
  const SE3 motion = pose(a).between(pose(b));
  if (a == b) return {motion, Matrix6::Zero()};
  Eigen::MatrixXd J(6, 12);
  J << -motion.inverse().adjoint(), Matrix6::Identity();
  return {motion, selection_.smoother().joint_covariance({pose_key(a), pose_key(b)}, J)};
}

TrackedCloud CloudMapper::add(const std::vector<Eigen::Vector3f>& points,
                              const Eigen::Vector3f& sensor,
                              const std::optional<UncertainMotion3>& odometry) {
  const TrackedCloud tracked = tracker_.track(points, sensor, odometry);
  const std::size_t k = tracked.cloud;
  Delta delta;
  if (k == 0) {
    delta.values.insert(pose_key(0), SE3());
    delta.continuous.push_back(
        std::make_shared<Prior<SE3>>(pose_key(0), SE3(), Noise::isotropic(6, kOrigin)));
    selection_.update(delta);
    return tracked;
  }
  delta.values.insert(pose_key(k), pose(k - 1) * tracked.T_before_cloud);
  for (const UncertainMotion3& motion : motions_to(tracked, odometry, tracker_.reach())) {
    delta.continuous.push_back(motion_factor(k - 1, k, motion));
  }
  selection_.update(delta);
  const std::vector<CloudClosure> found = search_.search(
      tracker_, [this](std::size_t i) { return pose(i); },
      [this](std::size_t a, std::size_t b) { return relation(a, b); });
  if (found.empty()) return tracked;
  std::vector<ContinuousFactorPtr> factors;
  Alternatives modes;
  for (const CloudClosure& closure : found) {
    modes.add(closure.first_mode);
    factors.push_back(motion_factor(closure.from, closure.to, closure.pose));
  }
  closures_.reserve(closures_.size() + found.size());
  selection_.update({}, factors, modes);
  closures_.insert(closures_.end(), found.begin(), found.end());
  return tracked;
}

void CloudMapper::finish() {
  if (tracker_.clouds() > 0) selection_.finish();
}

}  // namespace hybrid
