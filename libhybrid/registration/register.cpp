// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/registration/register.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/registration/alignment.h"
#include "libhybrid/registration/detail/cloud.h"

namespace hybrid {
namespace {

constexpr double kTurn = 35.0 * M_PI / 180.0;

/// The axes of a cube's faces and corners, both ways.
std::vector<Eigen::Vector3d> directions() {
  std::vector<Eigen::Vector3d> all;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const Eigen::Vector3d d(x, y, z);
        if (d.squaredNorm() == 1.0 || d.squaredNorm() == 3.0) all.push_back(d.normalized());
      }
    }
  }
  return all;
}

SE3 turned(const SE3& T_target_source, const Eigen::Vector3d& rotation,
           const Eigen::Vector3d& source_center, const Eigen::Vector3d& center) {
  const SO3 R = SO3::exp(rotation) * T_target_source.rotation();
  return {center - R * source_center, R};
}

/// Other starts than a given one, for clouds with little overlap: rotated about the centre of the
/// source in fourteen directions, each with that centre unmoved and with the centres of both clouds
/// together; and the given one with both centres together.
std::vector<SE3> other_starts(const SE3& T_target_source, const Eigen::Vector3d& source_center,
                              const Eigen::Vector3d& target_center) {
  std::vector<SE3> starts;
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  starts.push_back(turned(T_target_source, zero, source_center, target_center));
  for (const Eigen::Vector3d& d : directions()) {
    for (const Eigen::Vector3d& center : {T_target_source * source_center, target_center}) {
      starts.push_back(turned(T_target_source, kTurn * d, source_center, center));
    }
  }
  return starts;
}

// One setting for all clouds; lengths relative to the radius of the source.
constexpr double kFirstCell = 0.16;    // grid of the coarsest level; halves from level to level
constexpr double kFirstNoise = 0.5;    // noise along the surface of the first stage
constexpr double kShrink = 0.7;        // of the noise, from stage to stage
constexpr double kNoisePerCell = 0.7;  // last noise of a level, in cells
constexpr double kAcross = 0.3;        // noise across over noise along, before it is estimated
constexpr double kLeastNoise = 1e-5;   // lower bound of the noise of matches
constexpr double kFullLevel = 2.0;     // cells below this many spacings: all points
constexpr int kPairs = 15;             // of half-steps at most at one covariance
constexpr double kSettled = 0.05;      // motion that ends a stage, in standard deviations across
constexpr double kSettledLast = 0.02;  // the same for the last
constexpr int kContinuousSteps = 2;
constexpr std::size_t kKept = 4;  // starts that continue after the coarsest level
constexpr int kEstimates = 5;     // of the noise across, at most

/// Both clouds at one density, and the noise with which alternation at this level ends.
struct Level {
  Points source;
  std::unique_ptr<TargetCloud> target;
  double last_noise = 0.0;
};

/// The progress from one start.
struct Path {
  SE3 T_target_source;
  double objective = 0.0;
  int iterations = 0;
  std::vector<RegistrationStage> stages;
};

MatchNoise noise_along(double along, double gate) {
  return {kAcross * along, along, gate};
}

/// Alternation at the present noise (eq. 8), until the points move by less than `tolerance` times
/// the noise across.
void alternate(Alignment& alignment, std::size_t target_points, double tolerance, Path& path) {
  RegistrationStage stage;
  stage.source_points = alignment.size();
  stage.target_points = target_points;
  stage.noise = alignment.noise();
  for (int pair = 0; pair < kPairs; ++pair) {
    stage.objectives.push_back(alignment.match(path.T_target_source));
    if (pair > 0 && alignment.changes() == 0) break;
    const SE3 before = path.T_target_source;
    stage.objectives.push_back(alignment.align(path.T_target_source, kContinuousSteps));
    ++path.iterations;
    if (alignment.motion(before, path.T_target_source) < tolerance * stage.noise.across) break;
  }
  stage.inliers = alignment.inliers();
  path.objective = stage.objectives.back();
  path.stages.push_back(std::move(stage));
}

/// Alternates while the noise shrinks from `along` to the last noise of the level.
void descend(const Level& level, double along, double gate, WorkerPool& pool, Path& path) {
  Alignment alignment(level.source, *level.target, noise_along(along, gate), pool);
  while (true) {
    alternate(alignment, level.target->size(), kSettled, path);
    if (along <= level.last_noise) return;
    along = std::max(level.last_noise, kShrink * along);
    alignment.set_noise(noise_along(along, gate));
  }
}

/// Estimates the noise across from the matches at the noise of the level, and alternates with it. A
/// gate that shrank with its own matches would keep only the few that fit best.
void settle(Alignment& alignment, std::size_t target_points, double least, Path& path) {
  const MatchNoise level = alignment.noise();
  for (int i = 0; i < kEstimates; ++i) {
    const double wanted = std::max(alignment.noise_across(path.T_target_source), least);
    if (i > 0 && std::abs(wanted - path.stages.back().noise.across) < 0.1 * wanted) return;
    MatchNoise noise = level;
    noise.across = std::min(wanted, level.across);
    if (alignment.shape() == LocalShape::kPoint) noise.along = noise.across;
    alignment.set_noise(noise);
    alternate(alignment, target_points, kSettledLast, path);
    alignment.set_noise(level);
    alignment.match(path.T_target_source);
  }
}

class Registration {
 public:
  Registration(const Points& source, const Points& target, const RegistrationOptions& options)
      : options_(options), pool_(options.threads), spread_(spread_of(source)) {
    shape_ =
        options.metric == MatchMetric::kPoint ? LocalShape::kPoint : local_shape(source, target);
    build_levels(source, target);
  }

  RegistrationResult run() {
    Path best{options_.start, 0.0, 0, {}};
    for (std::size_t l = 0; l < levels_.size(); ++l) advance(l, pool_, best);
    int starts = 1;
    const double share = best.stages.back().inliers / double(levels_.back().source.size());
    if (share < options_.convincing_share) starts += search(best);
    RegistrationResult result = finish(best);
    result.starts = starts;
    return result;
  }

 private:
  void build_levels(const Points& source, const Points& target) {
    const double radius = spread_.radius();
    spacing_ = std::max({spacing_of(source), spacing_of(target), kLeastSpacing * radius});
    for (double cell = kFirstCell * radius;; cell *= 0.5) {
      const bool full = cell < kFullLevel * spacing_;
      Level level;
      level.source = full ? source : subsample(source, cell);
      level.target =
          std::make_unique<TargetCloud>(full ? target : subsample(target, cell), shape_, pool_);
      level.last_noise = full ? spacing_ : kNoisePerCell * cell;
      levels_.push_back(std::move(level));
      if (full) return;
    }
  }

  void advance(std::size_t l, WorkerPool& pool, Path& path) const {
    const double along = l == 0 ? kFirstNoise * spread_.radius() : levels_[l - 1].last_noise;
    descend(levels_[l], std::max(along, levels_[l].last_noise), options_.gate, pool, path);
  }

  /// Solves from all other starts at the coarsest level, from the best few at the next, and from
  /// the best of those to the end, where it replaces `best` if its objective is lower. Returns the
  /// number of starts.
  int search(Path& best) {
    std::vector<Path> paths;
    const Eigen::Vector3d target_center = spread_of(levels_.front().target->points()).center;
    for (const SE3& start : other_starts(options_.start, spread_.center, target_center)) {
      paths.push_back({start, 0.0, 0, {}});
    }
    const int count = static_cast<int>(paths.size());
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      if (paths.size() == 1) {
        advance(l, pool_, paths.front());
        continue;
      }
      pool_.run(static_cast<int>(paths.size()), [&](int i) {
        WorkerPool alone(1);
        advance(l, alone, paths[i]);
      });
      std::stable_sort(paths.begin(), paths.end(),
                       [](const Path& a, const Path& b) { return a.objective < b.objective; });
      paths.resize(l == 0 ? std::min(paths.size(), kKept) : 1);
    }
    if (paths.front().objective < best.objective) best = std::move(paths.front());
    return count;
  }

  RegistrationResult finish(Path& path) {
    const Level& level = levels_.back();
    Alignment alignment(level.source, *level.target, noise_along(level.last_noise, options_.gate),
                        pool_);
    RegistrationResult result;
    alignment.match(path.T_target_source);
    if (alignment.inliers() >= 3) {
      settle(alignment, level.target->size(), kLeastNoise * spread_.radius(), path);
      alignment.set_noise(path.stages.back().noise);
      path.objective = alignment.match(path.T_target_source);
    }
    result.T_target_source = path.T_target_source;
    result.shape = shape_;
    result.noise = alignment.noise();
    result.assignment = alignment.assignment();
    result.inliers = alignment.inliers();
    const Alignment::Residuals residuals = alignment.residuals(path.T_target_source);
    result.rms = residuals.all;
    result.rms_across = residuals.across;
    result.objective = path.objective;
    result.iterations = path.iterations;
    result.stages = std::move(path.stages);
    assess(alignment, result);
    return result;
  }

  void assess(const Alignment& alignment, RegistrationResult& result) const {
    if (result.inliers < 3) {
      result.status = RegistrationResult::Status::kNoMatch;
      return;
    }
    result.free_motions =
        free_motions(alignment, result.T_target_source, spread_.center, spread_.radius(), spacing_);
    if (!result.free_motions.empty()) {
      result.status = RegistrationResult::Status::kUnobservable;
    } else {
      result.covariance = covariance_of(alignment, result.T_target_source, spread_.center);
    }
  }

  RegistrationOptions options_;
  WorkerPool pool_;
  CloudSpread spread_;  // of the source
  LocalShape shape_ = LocalShape::kSurface;
  double spacing_ = 0.0;
  std::vector<Level> levels_;
};

}  // namespace

RegistrationResult register_clouds(const Points& source, const Points& target,
                                   const RegistrationOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  check_cloud(source, "the source cloud");
  check_cloud(target, "the target cloud");
  RegistrationResult result = Registration(source, target, options).run();
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
