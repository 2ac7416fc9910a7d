// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/objects/object_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "libhybrid/baselines/alternation.h"
#include "libhybrid/closures/closure_problem.h"
#include "libhybrid/closures/kernel.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostStarts = 200;  // sightings of an object that are tried as its pose

constexpr double kUnknown = 1e3;  // standard deviation of what is not known [m], [rad]

Noise isotropic(double metres, double radians) {
  SE3::Tangent sigmas;
  sigmas << metres, metres, metres, radians, radians, radians;
  return Noise::diagonal(sigmas);
}

/// The sum of squared whitened errors of an object pose, none above `most`.
double truncated_sum(const std::vector<SE3>& seen, const std::vector<Noise>& noise,
                     const SE3& object, double most) {
  double sum = 0.0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    sum +=
        std::min(most, (noise[i].sqrt_information() * seen[i].between(object).log()).squaredNorm());
  }
  return sum;
}

SE3 consensus(const std::vector<SE3>& seen, const std::vector<Noise>& noise, double most) {
  const std::size_t stride = 1 + (seen.size() - 1) / kMostStarts;
  SE3 best = seen.front();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < seen.size(); i += stride) {
    const double sum = truncated_sum(seen, noise, seen[i], most);
    if (sum < least) {
      least = sum;
      best = seen[i];
    }
  }
  return best;
}

/// A prior on the first camera pose, and odometry.
void add_path(const ObjectSequence& sequence, const ObjectNoise& noise, RobustProblem& problem) {
  const Noise step = isotropic(noise.step_m, noise.step_rad);
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
}

}  // namespace

ObjectNoise stated_noise(const ObjectSequence& sequence, const ObjectMapOptions& options) {
  isotropic(options.sighting_m, options.sighting_rad);  // throws where they are not positive
  isotropic(options.step_m, options.step_rad);
  ObjectNoise noise;
  noise.step_m = options.step_m;
  noise.step_rad = options.step_rad;
  noise.sightings.assign(sequence.objects.size(),
                         {options.sighting_m, options.sighting_m, options.sighting_rad, 1.0});
  noise.sightings_measured.assign(sequence.objects.size(), false);
  return noise;
}

RobustProblem object_problem(const ObjectSequence& sequence, const ObjectNoise& noise,
                             const ObjectMapOptions& options) {
  RobustProblem problem;
  add_path(sequence, noise, problem);
  const double most = 6.0 * std::log(options.mixture.outlier_variance);
  for (std::size_t k = 0; k < sequence.objects.size(); ++k) {
    std::vector<SE3> seen;
    std::vector<Noise> noises;
    for (std::size_t i = 0; i < sequence.odometry.size(); ++i) {
      const std::optional<SE3>& z = sequence.objects[k].sightings[i];
      if (!z) continue;
      seen.push_back(sequence.odometry[i] * *z);
      noises.push_back(noise.sightings[k].of(*z));
      problem.closures.push_back(
          std::make_shared<Between<SE3>>(camera_key(i), object_key(k), *z, noises.back()));
    }
    if (!seen.empty()) problem.initial.insert(object_key(k), consensus(seen, noises, most));
  }
  return problem;
}

RobustProblem object_problem(const ObjectSequence& sequence, const ObjectMapOptions& options) {
  return object_problem(sequence, stated_noise(sequence, options), options);
}

RobustResult solve_objects(const RobustProblem& problem, const ObjectMapOptions& options) {
  AlternationOptions alternation;
  alternation.mixture = options.mixture;
  RobustResult result = solve_alternating(problem, alternation);
  for (const Loss& loss : {Loss::huber(), Loss::cauchy()}) {
    RobustProblem elsewhere = problem;
    const RobustResult start = solve_objects(problem, loss, options);
    elsewhere.initial = start.values;
    RobustResult other = solve_alternating(elsewhere, alternation);
    other.seconds += result.seconds + start.seconds;
    other.iterations += result.iterations + start.iterations;
    if (other.objective < result.objective) {
      result = std::move(other);
    } else {
      result.seconds = other.seconds;
      result.iterations = other.iterations;
    }
  }
  result.method = "switches";
  return result;
}

RobustResult count_repetitions(const ObjectSequence& sequence, const ObjectNoise& noise,
                               const RobustResult& decided) {
  RobustProblem path;
  add_path(sequence, noise, path);
  HybridGraph graph(path.trusted);
  std::size_t sighting = 0;
  for (std::size_t k = 0; k < sequence.objects.size(); ++k) {
    for (std::size_t i = 0; i < sequence.odometry.size(); ++i) {
      const std::optional<SE3>& z = sequence.objects[k].sightings[i];
      if (!z || !decided.decisions[sighting++].accepted()) continue;
      const Noise repeated = noise.sightings[k].of(*z).inflated(noise.sightings[k].repetitions);
      graph.add(std::make_shared<Between<SE3>>(camera_key(i), object_key(k), *z, repeated));
    }
  }
  // An object without any sighting that is true keeps the pose that it has.
  for (std::size_t k = 0; k < sequence.objects.size(); ++k) {
    if (!decided.values.contains(object_key(k))) continue;
    graph.add(std::make_shared<Prior<SE3>>(object_key(k), decided.values.at<SE3>(object_key(k)),
                                           isotropic(kUnknown, kUnknown)));
  }
  const SolverResult solved = levenberg_marquardt(graph, {decided.values, {}});
  RobustResult result = decided;
  result.values = solved.values;
  result.seconds += solved.report.seconds;
  result.iterations += solved.report.iterations;
  result.converged = decided.converged && solved.report.status == SolverStatus::kConverged;
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
  return consensus(poses, std::vector<Noise>(poses.size(), isotropic(0.01, 0.02)), 100.0);
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
