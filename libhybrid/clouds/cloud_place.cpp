// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_place.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/clouds/detail/plan_view.h"
#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/evenly_chosen.h"
#include "libhybrid/scans/surface_map.h"

namespace hybrid {
namespace {

/// Points of planar scans are so far apart in the units of their search; clouds are scaled to it.
constexpr double kPlanSpacing = 0.1;
/// Things that are so many points high are in the plan: what is lower lies everywhere.
constexpr double kTall = 3;
/// Way that a local map spans [spacings].
constexpr double kMapSpacings = 4 / 0.03;
/// Heights of places that are closer are one [spacings], and heights about each are tried in steps
/// of so many, so many up and down.
constexpr double kOneHeight = 5;
constexpr double kClimb = 1.5;
constexpr int kClimbs = 2;
constexpr std::size_t kClimbPoints = 400;   // that choose one of these
constexpr std::size_t kPlacePoints = 2000;  // that are aligned
/// A pose in space has so many of its points on surfaces, and of two poses one is right if its
/// support is larger by this.
constexpr double kLeastInliers = 0.5;
constexpr double kBetterSupport = 0.05;
/// Standard deviations that a place of the drive may be off from a known start: of the drive up to
/// it [spacings], [rad].
constexpr double kStartSpacings = 1;
constexpr double kStartAngle = 0.02;
/// Probability with which a known start allows the true one.
constexpr double kSureOfIt = 0.9999;

SE3 turned(const Eigen::Matrix3d& R) {
  return {Eigen::Vector3d::Zero(), Eigen::Quaterniond(R)};
}

SE3 turned_as(const SE3& pose) {
  return {Eigen::Vector3d::Zero(), pose.rotation()};
}

SE3 levelling_of(const std::vector<StoredCloud>& stored) {
  std::vector<CloudPoint> all;
  for (const StoredCloud& cloud : stored) {
    const auto points =
        transformed(cloud.T_map_anchor.motion, evenly_chosen(cloud.points, kPlacePoints));
    all.insert(all.end(), points.begin(), points.end());
  }
  return turned(levelling(all));
}

/// The same in a frame that is at the inverse of `T`: covariances are those of the anchors.
std::vector<StoredCloud> moved(const SE3& T, std::vector<StoredCloud> stored) {
  for (StoredCloud& cloud : stored) cloud.T_map_anchor.motion = T * cloud.T_map_anchor.motion;
  return stored;
}

SE2 scaled(const SE2& pose, double scale) {
  return {scale * pose.translation(), pose.rotation()};
}

Eigen::Matrix3d scaled(const Eigen::Matrix3d& covariance, double scale) {
  const Eigen::Vector3d s(scale, scale, 1);
  return s.asDiagonal() * covariance * s.asDiagonal();
}

SE2 plan_of(const SE3& pose) {
  const Eigen::Vector3d& t = pose.translation();
  return {t.x(), t.y(), yaw_of(pose.rotation().matrix())};
}

/// The part of a covariance that a plan shows, in the tangent of the pose seen from above.
UncertainMotion plan_of(const UncertainMotion3& known) {
  const Eigen::Matrix3d level = level_of(known.motion);
  Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
  J.topLeftCorner<2, 3>() = level.topRows<2>();
  J.bottomRightCorner<1, 3>() = level.bottomRows<1>();
  return {plan_of(known.motion), J * known.covariance * J.transpose()};
}

/// Walls and poles from above, in units of planar scans.
std::vector<SurfacePoint> plan_of(const std::vector<CloudPoint>& points,
                                  const Eigen::Matrix3d& level, double scale) {
  std::vector<SurfacePoint> walls = walls_of(points, level);
  for (SurfacePoint& wall : walls) {
    wall.position *= scale;
    wall.length = kPlanSpacing;
  }
  std::vector<SurfacePoint> out;
  const SurfaceMap merged(walls, kPlanSpacing);
  for (const SurfaceMap::Surfel& surfel : merged.surfels()) {
    if (surfel.count < kTall) continue;
    out.push_back({surfel.position, surfel.normal, kPlanSpacing});
  }
  return out;
}

std::vector<StoredScans> plans_of(const std::vector<StoredCloud>& stored, double scale) {
  std::vector<StoredScans> out;
  for (const StoredCloud& cloud : stored) {
    const UncertainMotion at = plan_of(cloud.T_map_anchor);
    out.push_back({{scaled(at.motion, scale), scaled(at.covariance, scale)},
                   plan_of(cloud.points, level_of(cloud.T_map_anchor.motion), scale)});
  }
  return out;
}

ScanPlaceOptions plan_options(const CloudPlaceOptions& options, const SE3& T_level_map,
                              double scale) {
  ScanPlaceOptions out;
  out.odds = options.odds;
  out.map_length = kMapSpacings * kPlanSpacing;
  if (!options.start) return out;
  const UncertainMotion start =
      plan_of(UncertainMotion3{T_level_map * options.start->motion, options.start->covariance});
  out.start = {scaled(start.motion, scale), scaled(start.covariance, scale)};
  return out;
}

}  // namespace

double widest_spacing(const std::vector<StoredCloud>& stored) {
  double out = 0;
  for (const StoredCloud& cloud : stored) out = std::max(out, cloud.spacing);
  return out > 0 ? out : 1.0;
}

double view_of(double spacing) {
  return PlaceTiles::kView * spacing / kPlanSpacing;
}

CloudPlaceSearch::CloudPlaceSearch(std::vector<StoredCloud> stored,
                                   const CloudPlaceOptions& options)
    : options_(options),
      T_level_map_(levelling_of(stored)),
      stored_(moved(T_level_map_, std::move(stored))),
      spacing_(widest_spacing(stored_)),
      scale_(kPlanSpacing / spacing_),
      plan_(plans_of(stored_, scale_), plan_options(options, T_level_map_, scale_)),
      doubt_("no stretch of its clouds fits the map") {
  for (const StoredCloud& cloud : stored_) {
    middles_.push_back(cloud.T_map_anchor.motion * middle_of(cloud.points));
  }
}

/// Heights of robots that were about a place in the plane: those of storeys.
std::vector<double> CloudPlaceSearch::heights_near(const Eigen::Vector2d& place) const {
  std::vector<double> all;
  for (std::size_t i = 0; i < stored_.size(); ++i) {
    if ((middles_[i].head<2>() - place).norm() > view()) continue;
    all.push_back(stored_[i].T_map_anchor.motion.translation().z());
  }
  std::sort(all.begin(), all.end());
  std::vector<double> out;
  for (const double z : all) {
    if (out.empty() || z - out.back() > kOneHeight * spacing_) out.push_back(z);
  }
  return out;
}

CloudSurfaces CloudPlaceSearch::surfaces_near(const Eigen::Vector2d& place) const {
  CloudSurfaces out(spacing_);
  for (std::size_t i = 0; i < stored_.size(); ++i) {
    if ((middles_[i].head<2>() - place).norm() > 2 * view()) continue;
    std::vector<CloudPoint> points = transformed(stored_[i].T_map_anchor.motion, stored_[i].points);
    points.erase(std::remove_if(points.begin(), points.end(),
                                [&](const CloudPoint& p) {
                                  return (p.position.head<2>().cast<double>() - place).norm() >
                                         2 * view();
                                }),
                 points.end());
    out.add(points);
  }
  return out;
}

/// Poses in space of a level frame with points at a place in the plane, the likeliest first.
std::vector<CloudAlignment> CloudPlaceSearch::poses_at(const std::vector<CloudPoint>& points,
                                                       const Eigen::Matrix3d& level,
                                                       const SE2& place) const {
  const CloudSurfaces surfaces = surfaces_near(place.translation());
  const std::vector<CloudPoint> used = evenly_chosen(points, kPlacePoints);
  const std::vector<CloudPoint> coarse = evenly_chosen(used, kClimbPoints);
  const Eigen::Quaterniond turn(turn_about_z(place.angle()) * level);
  const Eigen::Vector3d step = kClimb * spacing_ * Eigen::Vector3d::UnitZ();
  std::vector<CloudAlignment> out;
  for (const double z : heights_near(place.translation())) {
    const SE3 start(Eigen::Vector3d(place.x(), place.y(), z), turn);
    const CloudAlignment found =
        align(used, surfaces, at_best_height(coarse, surfaces, start, step, kClimbs));
    if (found.inliers < kLeastInliers) continue;
    const bool is_known = std::any_of(out.begin(), out.end(), [&](const CloudAlignment& other) {
      return are_one_pose(other.pose, found.pose, spacing_);
    });
    if (!is_known) out.push_back(found);
  }
  std::stable_sort(out.begin(), out.end(), [](const CloudAlignment& a, const CloudAlignment& b) {
    return a.support > b.support;
  });
  return out;
}

/// A pose with the uncertainty of the stored clouds there.
UncertainMotion3 CloudPlaceSearch::in_map(const CloudAlignment& found) const {
  const auto nearest = std::min_element(
      middles_.begin(), middles_.end(), [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
        return (a - found.pose.translation()).norm() < (b - found.pose.translation()).norm();
      });
  const UncertainMotion3& anchor =
      stored_[static_cast<std::size_t>(nearest - middles_.begin())].T_map_anchor;
  return anchor * UncertainMotion3{anchor.motion.between(found.pose), alignment_covariance(found)};
}

bool CloudPlaceSearch::is_allowed(const SE3& T_map_drive) const {
  if (!options_.start) return true;
  const SE3::Tangent e = options_.start->motion.between(T_map_drive).log();
  const Matrix6 C =
      options_.start->covariance + isotropic_covariance(kStartSpacings * spacing_, kStartAngle);
  return e.dot(C.ldlt().solve(e)) < chi_square_quantile(kSureOfIt, 6);
}

std::optional<UncertainMotion3> CloudPlaceSearch::look(const std::vector<CloudPoint>& points,
                                                       const SE3& stretch) {
  if (!T_level_drive_) T_level_drive_ = turned(levelling(transformed(turned_as(stretch), points)));
  const SE3 T_level_stretch = *T_level_drive_ * stretch;
  const Eigen::Matrix3d level = level_of(T_level_stretch);
  const SE2 seen = plan_of(T_level_stretch);
  const ScanPlace* found = plan_.look(plan_of(points, level, scale_), scaled(seen, scale_));
  if (found == nullptr) return std::nullopt;
  const SE2 place = scaled(found->T_map_drive.motion * scaled(seen, scale_), 1 / scale_);
  const SE3 T_map_level = T_level_map_.inverse(), T_stretch_drive = stretch.inverse();
  std::vector<CloudAlignment> poses = poses_at(points, level, place);
  poses.erase(std::remove_if(poses.begin(), poses.end(),
                             [&](const CloudAlignment& p) {
                               return !is_allowed(T_map_level * p.pose * T_stretch_drive);
                             }),
              poses.end());
  if (poses.empty()) {
    doubt_ = "its walls fit at a place where its surfaces do not";
    return std::nullopt;
  }
  if (poses.size() > 1 && poses[1].support > poses[0].support - kBetterSupport) {
    doubt_ = "its clouds fit at two heights of one place";
    return std::nullopt;
  }
  const UncertainMotion3 here = in_map(poses.front());
  return UncertainMotion3{T_map_level * here.motion, here.covariance} *
         UncertainMotion3{T_stretch_drive, Matrix6::Zero()};
}

std::optional<UncertainMotion3> CloudPlaceSearch::look(const CloudMapper& mapper) {
  const CloudTracker& tracker = mapper.tracker();
  if (tracker.surfaces() == nullptr || stored_.empty()) return std::nullopt;
  const LocalCloud& present = tracker.local_maps().back();
  if (!plan_.is_due(scale_ * present.travelled.back())) return std::nullopt;
  const std::vector<CloudPoint> points =
      transformed(present.poses.back().inverse(), tracker.surfaces()->points());
  const std::size_t last = tracker.clouds() - 1;
  const auto found = look(points, mapper.pose(last));
  if (!found) return std::nullopt;
  return *found * UncertainMotion3{mapper.pose(last), Matrix6::Zero()} * mapper.relation(last, 0);
}

}  // namespace hybrid
