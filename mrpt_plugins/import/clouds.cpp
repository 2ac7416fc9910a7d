// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/clouds.h"

#include <fmt/format.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "libhybrid/core/error.h"
#include "libhybrid/geometry/thin_points.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/import/detail/camera.h"
#include "mrpt_plugins/import/detail/cloud_files.h"
#include "mrpt_plugins/import/detail/pose_rows.h"
#include "mrpt_plugins/import/detail/table_odometry.h"
#include "mrpt_plugins/input/odometry_reset.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

constexpr std::size_t kMostNoted = 3;  // clouds that cannot be read, each with its file

mrpt::obs::CObservationPointCloud::Ptr observation_of(const Points& points, const char* label,
                                                      const CPose3D& T_robot_sensor) {
  auto map = mrpt::maps::CSimplePointsMap::Create();
  map->reserve(points.size());
  for (const Eigen::Vector3d& p : points) {
    map->insertPointFast(static_cast<float>(p.x()), static_cast<float>(p.y()),
                         static_cast<float>(p.z()));
  }
  map->mark_as_modified();
  auto out = mrpt::obs::CObservationPointCloud::Create();
  out->sensorLabel = label;
  out->sensorPose = T_robot_sensor;
  out->pointcloud = map;
  return out;
}

/// Poses of all clouds, or none of any; some are not known where poses are interpolated.
using CloudPoses = std::vector<std::optional<PoseRow>>;

/// The poses at the times of clouds, which do not fall; not known before the first and after the
/// last one.
CloudPoses interpolated(const std::vector<PoseRow>& rows, const std::vector<double>& times) {
  CloudPoses poses;
  std::size_t after = 0;
  for (const double time : times) {
    while (after < rows.size() && *rows[after].time < time) ++after;
    std::optional<PoseRow> pose;
    if (after < rows.size() && *rows[after].time == time) {
      pose = rows[after];
    } else if (after > 0 && after < rows.size()) {
      const PoseRow &a = rows[after - 1], &b = rows[after];
      pose = PoseRow{time, pose_between({*a.time, a.pose}, {*b.time, b.pose}, time)};
    }
    poses.push_back(pose);
  }
  return poses;
}

/// The poses of a file, one for each cloud, or interpolated where names of clouds are times; none
/// without a file.
CloudPoses read_poses(const std::string& path, bool are_of_camera, const CloudsOptions& options,
                      const CloudFolder& folder) {
  if (path.empty()) return {};
  std::vector<PoseRow> rows = read_pose_rows(path);
  for (PoseRow& row : rows) {
    if (are_of_camera) row.pose = robot_pose(row.pose);
  }
  if (rows.size() == folder.clouds.size()) return {rows.begin(), rows.end()};
  if (folder.stamps.empty() || !rows.front().time) {
    throw Error(fmt::format("{}: {} poses, and {} has {} clouds; one pose is expected for each",
                            path, rows.size(), options.folder, folder.clouds.size()));
  }
  CloudPoses poses = interpolated(rows, folder.stamps);
  if (std::none_of(poses.begin(), poses.end(), [](const auto& pose) { return pose.has_value(); })) {
    throw Error(
        fmt::format("{}: no cloud of {} has poses around it: clouds are of {} to {} s, "
                    "poses of {} to {} s; times of both are of one clock",
                    path, options.folder, folder.stamps.front(), folder.stamps.back(),
                    *rows.front().time, *rows.back().time));
  }
  return poses;
}

class CloudsImport {
 public:
  CloudsImport(const CloudsOptions& options, const std::string& output)
      : options_(options),
        folder_(clouds_in(options.folder)),
        files_(options, folder_.are_images),
        log_(output) {
    const std::vector<double>& p = options.sensor_pose;
    if (!p.empty() && p.size() != 6) throw Error("a sensor pose has six numbers");
    if (!p.empty()) T_robot_sensor_ = {p[0], p[1], p[2], p[3], p[4], p[5]};
    const bool are_of_camera = folder_.are_images && p.empty();
    odometry_ =
        read_poses(options.odometry, are_of_camera || options.camera_odometry, options, folder_);
    truth_ = read_poses(options.truth, are_of_camera || options.camera_truth, options, folder_);
  }

  ImportReport run() {
    for (std::size_t i = 0; i < folder_.clouds.size(); ++i) {
      log_.used(static_cast<double>(i + 1) / static_cast<double>(folder_.clouds.size()));
      if (!has_poses(i)) {
        log_.drop("cloud dropped: no pose before or after it");
      } else if (const std::optional<CloudPoints> cloud = read(folder_.clouds[i])) {
        add(i, *cloud);
      }
    }
    if (log_.steps() == 0) {
      throw Error(fmt::format("{}: none of {} clouds can be read; the first: {}", options_.folder,
                              folder_.clouds.size(), first_fault_));
    }
    note_all();
    return log_.finish();
  }

 private:
  bool has_poses(std::size_t i) const {
    return (odometry_.empty() || odometry_[i]) && (truth_.empty() || truth_[i]);
  }

  /// Nothing where the file cannot be read.
  std::optional<CloudPoints> read(const std::string& path) {
    try {
      return files_.read(path);
    } catch (const Interrupted&) {
      throw;
    } catch (const Error& e) {
      if (unread_++ == 0) first_fault_ = e.what();
      if (unread_ <= kMostNoted) log_.note(e.what());
    }
    log_.drop("cloud dropped: its file cannot be read");
    return std::nullopt;
  }

  void add(std::size_t i, const CloudPoints& cloud) {
    const std::size_t most =
        options_.most_points > 0 ? options_.most_points : std::numeric_limits<std::size_t>::max();
    const Points kept = thin_points(cloud.points, most);
    points_ += cloud.points.size() + cloud.not_finite + cloud.too_far;
    kept_ += kept.size();
    if (cloud.not_finite > 0) log_.drop("point dropped: not finite", cloud.not_finite);
    if (cloud.too_far > 0) log_.drop("point dropped: beyond the maximum range", cloud.too_far);
    const std::size_t thinned = cloud.points.size() - kept.size();
    if (thinned > 0) log_.drop("point dropped: another one of its voxel is kept", thinned);
    if (kept.empty()) log_.drop("cloud kept without points: it has none");
    ImportedStep step{time_of(i), motion_to(i), {}, {}};
    step.observations.push_back(
        observation_of(kept, folder_.are_images ? "DEPTH" : "LIDAR", T_robot_sensor_));
    if (!truth_.empty()) step.truth = truth_[i]->pose;
    log_.add(step);
  }

  double time_of(std::size_t i) const {
    for (const CloudPoses* poses : {&odometry_, &truth_}) {
      if (!poses->empty() && (*poses)[i]->time) return *(*poses)[i]->time;
    }
    if (!folder_.stamps.empty()) return folder_.stamps[i];
    return static_cast<double>(i) * options_.period;
  }

  /// The motion from the last cloud that was kept.
  std::optional<OdometryIncrement> motion_to(std::size_t i) {
    if (odometry_.empty()) return std::nullopt;
    const CPose3D& pose = odometry_[i]->pose;
    std::optional<OdometryIncrement> motion;
    if (reset_.at({pose.x(), pose.y(), pose.z()})) {
      log_.drop(OdometryReset::kDropped);
    } else if (last_) {
      motion =
          wandering_motion(*last_, pose, true, options_.walk_translation, options_.walk_rotation);
    }
    last_ = pose;
    return motion;
  }

  void note_all() {
    log_.note(fmt::format("{} clouds with {} points, of which {} are kept", log_.steps(), points_,
                          kept_));
    if (unread_ > kMostNoted) {
      log_.note(fmt::format("{} further clouds cannot be read", unread_ - kMostNoted));
    }
    if (folder_.others > 0) {
      log_.note(fmt::format("{}: files that are no clouds are left aside: {}, such as {}",
                            options_.folder, folder_.others, folder_.another));
    }
    if (!folder_.are_images) log_.note("intensities and colours are not kept");
    for (const std::string& path : {options_.odometry, options_.truth}) {
      if (!path.empty()) log_.note_end(path);
    }
  }

  const CloudsOptions& options_;
  CloudFolder folder_;
  CloudFiles files_;
  LogWriter log_;
  CPose3D T_robot_sensor_;
  CloudPoses odometry_, truth_;
  OdometryReset reset_;
  std::optional<CPose3D> last_;  // by odometry, at the last cloud that was kept
  std::size_t points_ = 0, kept_ = 0, unread_ = 0;
  std::string first_fault_;
};

}  // namespace

ImportReport import_clouds(const CloudsOptions& options, const std::string& output) {
  return CloudsImport(options, output).run();
}

}  // namespace hybrid
