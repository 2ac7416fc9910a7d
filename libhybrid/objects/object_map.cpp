// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/objects/object_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "libhybrid/baselines/alternation.h"
#include "libhybrid/closures/closure_problem.h"
#include "libhybrid/closures/kernel.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostStarts = 200;  // sightings of an object that are tried as its pose

Noise noise(double metres, double radians) {
  SE3::Tangent sigmas;
  sigmas << metres, metres, metres, radians, radians, radians;
  return Noise::diagonal(sigmas);
}

/// The sum of squared whitened errors of an object pose, none above `most`.
double truncated_sum(const std::vector<SE3>& seen, const SE3& object, const Noise& sighting,
                     double most) {
  double sum = 0.0;
  for (const SE3& other : seen) {
    sum +=
        std::min(most, (sighting.sqrt_information() * other.between(object).log()).squaredNorm());
  }
  return sum;
}

SE3 consensus(const std::vector<SE3>& seen, const Noise& sighting, double most) {
  const std::size_t stride = 1 + (seen.size() - 1) / kMostStarts;
  SE3 best = seen.front();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < seen.size(); i += stride) {
    const double sum = truncated_sum(seen, seen[i], sighting, most);
    if (sum < least) {
      least = sum;
      best = seen[i];
    }
  }
  return best;
}

}  // namespace

RobustProblem object_problem(const ObjectSequence& sequence, const ObjectMapOptions& options) {
  RobustProblem problem;
  const Noise step = noise(options.step_m, options.step_rad);
  const Noise sighting = noise(options.sighting_m, options.sighting_rad);
  const std::vector<SE3>& path = sequence.odometry;
  for (std::size_t i = 0; i < path.size(); ++i) {
    problem.initial.insert(camera_key(i), path[i]);
    if (i == 0) {
      problem.trusted.push_back(std::make_shared<Prior<SE3>>(camera_key(0), path[0], step));
    } else {
      problem.trusted.push_back(std::make_shared<Between<SE3>>(camera_key(i - 1), camera_key(i),
                                                               path[i - 1].between(path[i]), step));
    }
  }
  const double most = 6.0 * std::log(options.mixture.outlier_variance);
  for (std::size_t k = 0; k < sequence.objects.size(); ++k) {
    std::vector<SE3> seen;
    for (std::size_t i = 0; i < path.size(); ++i) {
      const std::optional<SE3>& z = sequence.objects[k].sightings[i];
      if (!z) continue;
      seen.push_back(path[i] * *z);
      problem.closures.push_back(
          std::make_shared<Between<SE3>>(camera_key(i), object_key(k), *z, sighting));
    }
    if (!seen.empty()) problem.initial.insert(object_key(k), consensus(seen, sighting, most));
  }
  return problem;
}

RobustResult solve_objects(const RobustProblem& problem, const ObjectMapOptions& options) {
  AlternationOptions alternation;
  alternation.mixture = options.mixture;
  RobustResult result = solve_alternating(problem, alternation);
  result.method = "switches";
  return result;
}

RobustResult solve_objects(const RobustProblem& problem, const Loss& loss,
                           const ObjectMapOptions& options) {
  const Kernel kernel{[loss](double s) { return loss.value(s); },
                      [loss](double s) { return loss.weight(s); }};
  ComparisonOptions comparison;
  comparison.mixture = options.mixture;
  RobustResult result =
      solve_kernels(problem, std::vector<Kernel>(problem.closures.size(), kernel), 0.5, comparison);
  result.method = loss.kind == Loss::Kind::kHuber ? "huber" : "cauchy";
  return result;
}

namespace {

/// The true pose of a static object: of its true poses by frame, the one that agrees best with the
/// others.
std::optional<SE3> true_pose(const ObjectSequence& sequence, const ObjectTrack& track) {
  std::vector<SE3> poses;
  for (std::size_t i = 0; i < track.truth.size(); ++i) {
    if (track.truth[i]) poses.push_back(sequence.truth[i] * *track.truth[i]);
  }
  if (poses.empty()) return std::nullopt;
  return consensus(poses, noise(0.01, 0.02), 100.0);
}

}  // namespace

ObjectMapErrors object_map_errors(const ObjectSequence& sequence, const Values& values) {
  const std::size_t frames = sequence.truth.size();
  if (frames == 0) throw Error("the sequence has no true camera poses (cam_gt.txt)");
  Eigen::Matrix3Xd estimate(3, frames), truth(3, frames);
  for (std::size_t i = 0; i < frames; ++i) {
    estimate.col(i) = values.at<SE3>(camera_key(i)).translation();
    truth.col(i) = sequence.truth[i].translation();
  }
  const Eigen::Matrix4d aligned = Eigen::umeyama(estimate, truth, false);
  const SE3 T_world_map(aligned.topRightCorner<3, 1>(),
                        Eigen::Quaterniond(Eigen::Matrix3d(aligned.topLeftCorner<3, 3>())));
  ObjectMapErrors errors;
  errors.T_world_map = T_world_map;
  double squares = 0.0;
  for (std::size_t i = 0; i < frames; ++i) {
    squares += (T_world_map * Eigen::Vector3d(estimate.col(i)) - truth.col(i)).squaredNorm();
  }
  errors.trajectory_m = std::sqrt(squares / static_cast<double>(frames));
  for (std::size_t k = 0; k < sequence.objects.size(); ++k) {
    const std::optional<SE3> object = true_pose(sequence, sequence.objects[k]);
    errors.objects.push_back(object);
    const bool known = object && values.contains(object_key(k));
    const double none = std::numeric_limits<double>::quiet_NaN();
    const SE3 error = known ? object->between(T_world_map * values.at<SE3>(object_key(k))) : SE3();
    errors.object_m.push_back(known ? error.translation().norm() : none);
    errors.object_deg.push_back(known ? error.rotation().log().norm() * 180.0 / M_PI : none);
  }
  return errors;
}

}  // namespace hybrid
