// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/kitti.h"

#include <fmt/format.h>

#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/import/detail/camera.h"
#include "mrpt_plugins/import/detail/kitti_boxes.h"
#include "mrpt_plugins/import/detail/kitti_odometry.h"
#include "mrpt_plugins/import/detail/oracle.h"

namespace hybrid {
namespace {

constexpr std::size_t kMinOracleSightings = 5;

using mrpt::poses::CPose3D;

/// The true poses, one for each image.
class Truth {
 public:
  Truth(const std::string& path, bool is_3d) : path_(path), is_3d_(is_3d) {
    if (!path.empty()) table_.emplace(path);
  }

  /// The next pose; empty without a file.
  std::optional<CPose3D> next() {
    if (!table_) return std::nullopt;
    const auto row = table_->next();
    if (!row)
      throw Error(fmt::format("{}: ends with pose {}, the odometry goes on", path_, count_));
    ++count_;
    const CPose3D pose = robot_pose(*row, 0);
    return is_3d_ ? pose : flattened(pose);
  }

  void finish() {
    if (!table_) return;
    if (const auto row = table_->next()) {
      row->fail(fmt::format("more than {} true poses, the odometry has no more", count_));
    }
  }

 private:
  std::string path_;
  bool is_3d_;
  std::optional<TextReader> table_;
  std::size_t count_ = 0;
};

/// True ids of all sightings in their order, by their positions in the plane according to the true
/// poses. Only ids with enough sightings.
std::vector<std::int32_t> true_ids(const KittiOptions& options, bool is_3d) {
  if (options.oracle_radius <= 0) return {};
  if (options.truth.empty()) throw Error("an oracle radius needs true poses");
  DropReport ignored;
  Boxes boxes(options, is_3d, ignored);
  TextReader truth(options.truth);
  std::vector<PlacedSighting> placed;
  for (std::size_t frame = 0; const auto row = truth.next(); ++frame) {
    const CPose3D pose = is_3d ? robot_pose(*row, 0) : flattened(robot_pose(*row, 0));
    for (const BoxSighting& s : boxes.of(frame)) {
      const Eigen::Vector3d q = transformed(pose, s.point);
      placed.push_back({{q.x(), q.y(), 0}});
    }
  }
  return number_by_place(placed, options.oracle_radius, kMinOracleSightings);
}

CObservationClassedBearingRange::Ptr make_frame(bool is_3d) {
  auto frame = planar_detections("CAMERA", {1.0, 0, 0.05, 0}, {});
  frame->has_pitch = is_3d;
  if (is_3d) frame->std_pitch = 0.05F;
  frame->class_names = kitti_box_classes();
  return frame;
}

}  // namespace

ImportReport import_kitti(const KittiOptions& options, const std::string& output) {
  LogWriter log(output);
  DropReport dropped;
  KittiOdometry odometry(options);
  Boxes boxes(options, odometry.is_3d(), dropped);
  Truth truth(options.truth, odometry.is_3d());
  const std::vector<std::int32_t> ids = true_ids(options, odometry.is_3d());
  auto id = ids.begin();
  std::optional<OdometryIncrement> motion;
  do {
    ImportedStep step;
    step.time = static_cast<double>(odometry.count()) * options.period;
    step.motion = motion;
    step.truth = truth.next();
    auto frame = make_frame(odometry.is_3d());
    for (BoxSighting& s : boxes.of(odometry.count())) {
      if (id != ids.end()) s.detection.true_landmark_id = *id++;
      frame->detections.push_back(std::move(s.detection));
    }
    step.observations.push_back(frame);
    log.used(odometry.share());
    log.add(step);
    motion = odometry.next(dropped);
  } while (motion);
  truth.finish();
  boxes.finish();
  for (const std::string& path : {options.odometry, options.boxes, options.truth}) {
    if (!path.empty()) log.note_end(path);
  }
  if (odometry.is_3d() && !options.covariances.empty()) log.note_end(options.covariances);
  for (const auto& [reason, count] : dropped) log.drop(reason, count);
  return log.finish();
}

}  // namespace hybrid
