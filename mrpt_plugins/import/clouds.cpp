// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/clouds.h"

#include <fmt/format.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/clouds/cloud_sweep.h"
#include "libhybrid/core/error.h"
#include "libhybrid/geometry/points.h"
#include "libhybrid/geometry/thin_points.h"
#include "libhybrid/io/point_formats.h"
#include "libhybrid/io/read_points.h"
#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/import/detail/camera.h"
#include "mrpt_plugins/import/detail/cloud_files.h"
#include "mrpt_plugins/import/detail/log_time.h"
#include "mrpt_plugins/import/detail/pose_rows.h"
#include "mrpt_plugins/import/detail/table_odometry.h"
#include "mrpt_plugins/input/odometry_reset.h"
#include "mrpt_plugins/rawlog/image_decoder.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

constexpr std::size_t kMostNoted = 3;  // clouds that cannot be read, each with its file

constexpr std::uint64_t kLargestCloud = std::uint64_t{1} << 30;  // bytes

using Indices = std::vector<std::size_t>;

/// The points of a file.
struct CloudPoints {
  Points points;               // x ahead, y to the left, z up, of the sensor [m]
  std::vector<double> times;   // of each, as the file has them [s], or none
  std::size_t not_finite = 0;  // points left out
  std::size_t too_far = 0;     // beyond the maximum range
};

/// Reads clouds one by one.
class CloudFiles {
 public:
  /// Throws Error where something of the options does not fit.
  CloudFiles(const CloudsOptions& options, bool are_images);

  /// Throws Error that names the file where it cannot be read.
  CloudPoints read(const std::string& path);

 private:
  CloudPoints read_depths(const std::string& path);

  const CloudsOptions& options_;
  bool are_images_;
  DepthDecoder decoder_;
};

CloudFiles::CloudFiles(const CloudsOptions& options, bool are_images)
    : options_(options), are_images_(are_images) {
  if (are_images && !(options.focal > 0)) {
    throw Error(
        fmt::format("{}: depth images need --focal, the focal length in pixels", options.folder));
  }
}

CloudPoints CloudFiles::read(const std::string& path) {
  if (are_images_) return read_depths(path);
  PointFile file = extension_of(path) == ".bin" ? read_kitti(path) : read_cloud(path);
  CloudPoints cloud{std::move(file.points), std::move(file.times), file.left_out, 0};
  if (!(options_.max_range > 0)) return cloud;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (cloud.points[i].norm() > options_.max_range) continue;
    cloud.points[kept] = cloud.points[i];
    if (!cloud.times.empty()) cloud.times[kept] = cloud.times[i];
    ++kept;
  }
  cloud.too_far = cloud.points.size() - kept;
  cloud.points.resize(kept);
  cloud.times.resize(std::min(kept, cloud.times.size()));
  return cloud;
}

CloudPoints CloudFiles::read_depths(const std::string& path) {
  const std::optional<DepthImage> image = decoder_.decode(read_file(path, kLargestCloud));
  if (!image) throw Error(path + ": not a depth image, a PNG of one channel of 16 bits");
  const double u0 = options_.center_u < 0 ? image->width / 2.0 : options_.center_u;
  const double v0 = options_.center_v < 0 ? image->height / 2.0 : options_.center_v;
  CloudPoints cloud;
  auto depth = image->depths.begin();
  for (int v = 0; v < image->height; ++v) {
    for (int u = 0; u < image->width; ++u) {
      const double z = *depth++ * options_.depth_unit;
      if (z == 0) continue;
      if (options_.max_range > 0 && z > options_.max_range) {
        ++cloud.too_far;
        continue;
      }
      cloud.points.push_back(
          robot_point({(u - u0) / options_.focal * z, (v - v0) / options_.focal * z, z}));
    }
  }
  return cloud;
}

mrpt::obs::CObservation::Ptr points_alone(const Points& points, const Indices& kept) {
  auto map = mrpt::maps::CSimplePointsMap::Create();
  map->reserve(kept.size());
  for (const std::size_t i : kept) {
    const Eigen::Vector3f p = points[i].cast<float>();
    map->insertPointFast(p.x(), p.y(), p.z());
  }
  map->mark_as_modified();
  auto out = mrpt::obs::CObservationPointCloud::Create();
  out->pointcloud = map;
  return out;
}

/// The class of MRPT whose points have times. `time` is that of the cloud, by which those of its
/// points are relative [s].
mrpt::obs::CObservation::Ptr points_with_times(const Points& points,
                                               const std::vector<double>& times,
                                               const Indices& kept, double time) {
  const auto stamp = mrpt::Clock::fromDouble(time);
  auto out = mrpt::obs::CObservationVelodyneScan::Create();
  auto& cloud = out->point_cloud;
  for (const std::size_t i : kept) {
    const Eigen::Vector3f p = points[i].cast<float>();
    cloud.x.push_back(p.x());
    cloud.y.push_back(p.y());
    cloud.z.push_back(p.z());
    const std::chrono::duration<double> after(times[i]);
    cloud.timestamp.push_back(std::isfinite(times[i])
                                  ? stamp + std::chrono::round<mrpt::Clock::duration>(after)
                                  : INVALID_TIMESTAMP);
  }
  cloud.intensity.resize(kept.size());  // MRPT expects one of each point
  return out;
}

/// What the times of points are relative to: 0 where they are small, else the time of their cloud,
/// or their first one where they are of another clock.
double origin_of(const std::vector<double>& times, double time_of_cloud) {
  std::vector<double> known;
  std::copy_if(times.begin(), times.end(), std::back_inserter(known),
               [](double time) { return std::isfinite(time); });
  if (known.empty()) return 0;
  const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
  std::nth_element(known.begin(), middle, known.end());
  const double usual = *middle;
  for (const double origin : {0.0, time_of_cloud}) {
    if (std::abs(usual - origin) <= kLongestSweep) return origin;
  }
  double first = usual;
  for (const double time : known) {
    if (time > usual - kLongestSweep) first = std::min(first, time);
  }
  return first;
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
    const Indices kept = thin_points(cloud.points, most);
    points_ += cloud.points.size() + cloud.not_finite + cloud.too_far;
    kept_ += kept.size();
    if (cloud.not_finite > 0) log_.drop("point dropped: not finite", cloud.not_finite);
    if (cloud.too_far > 0) log_.drop("point dropped: beyond the maximum range", cloud.too_far);
    const std::size_t thinned = cloud.points.size() - kept.size();
    if (thinned > 0) log_.drop("point dropped: another one of its voxel is kept", thinned);
    if (kept.empty()) log_.drop("cloud kept without points: it has none");
    ImportedStep step{time_of(i), motion_to(i), {}, {}};
    const std::vector<double> times = times_of(cloud, step.time);
    auto seen = times.empty() ? points_alone(cloud.points, kept)
                              : points_with_times(cloud.points, times, kept, step.time);
    seen->sensorLabel = folder_.are_images ? "DEPTH" : "LIDAR";
    seen->setSensorPose(T_robot_sensor_);
    step.observations.push_back(seen);
    if (!truth_.empty()) step.truth = truth_[i]->pose;
    log_.add(step);
  }

  /// Times of points relative to that of their cloud [s], NaN where one is not known; none where no
  /// one is.
  std::vector<double> times_of(const CloudPoints& cloud, double time) {
    std::vector<double> times = cloud.times;
    const double origin = origin_of(times, time);
    has_other_clock_ = has_other_clock_ || (origin != 0 && origin != time);
    std::size_t unknown = 0;
    for (double& of_point : times) {
      of_point -= origin;
      if (std::abs(of_point) <= kLongestSweep) continue;
      of_point = std::numeric_limits<double>::quiet_NaN();
      ++unknown;
    }
    if (unknown > 0)
      log_.drop("time of a point dropped: not within a second of its cloud", unknown);
    if (unknown == times.size()) times.clear();
    has_times_ = has_times_ || !times.empty();
    return times;
  }

  double time_of(std::size_t i) const {
    for (const CloudPoses* poses : {&odometry_, &truth_}) {
      if (!poses->empty() && (*poses)[i]->time) return *(*poses)[i]->time;
    }
    if (!folder_.stamps.empty()) return folder_.stamps[i];
    return log_time(static_cast<double>(i) * options_.period);
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
    if (has_times_) log_.note("points have times");
    if (has_other_clock_) {
      log_.note(
          "times of points are of another clock than those of clouds: the first point of each is "
          "taken to be seen at the time of its cloud");
    }
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
  bool has_times_ = false, has_other_clock_ = false;
};

}  // namespace

ImportReport import_clouds(const CloudsOptions& options, const std::string& output) {
  return CloudsImport(options, output).run();
}

}  // namespace hybrid
