// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/kitti.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/import/camera.h"
#include "mrpt_plugins/import/kitti_boxes.h"
#include "mrpt_plugins/import/oracle.h"
#include "mrpt_plugins/input/text_table.h"

namespace hybrid {
namespace {

constexpr std::size_t kMinOracleSightings = 5;
constexpr double kSigmaTranslation = 0.03, kSigmaRotation = 0.002;  // per frame

using mrpt::poses::CPose3D;

OdometryIncrement planar_edge(const TextRow& row) {
  row.expect_columns(12, 12, "EDGE_SE2 i j x y angle and 6 numbers of information");
  Eigen::Matrix3d information;
  std::size_t column = 6;
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = i; j < 3; ++j) {
      information(i, j) = information(j, i) = row.number(column++);
    }
  }
  if (!(information.llt().info() == Eigen::Success)) row.fail("information not positive definite");
  return planar_motion(row.number(3), row.number(4), row.number(5), information.inverse());
}

/// The camera is ahead of the rear axle, so a turn moves it sideways to the inside of the turn. An
/// odometry where it goes the other way has its y to the right: turned to the left.
void repair_lateral(std::vector<OdometryIncrement>& motions, LogWriter& log) {
  double inwards = 0;
  for (const OdometryIncrement& motion : motions) inwards += motion.mean.y() * motion.mean.yaw();
  if (inwards >= 0) return;
  const Eigen::Vector3d mirror(1, -1, 1);
  for (OdometryIncrement& motion : motions) {
    motion =
        planar_motion(motion.mean.x(), -motion.mean.y(), motion.mean.yaw(),
                      mirror.asDiagonal() * planar_part(motion.covariance) * mirror.asDiagonal());
  }
  log.drop("motion repaired: the y of the odometry pointed to the right", motions.size());
}

/// Motions between consecutive images, in the plane.
std::vector<OdometryIncrement> read_planar_odometry(const std::string& path, LogWriter& log) {
  std::vector<OdometryIncrement> motions;
  TextTable table(path);
  while (const auto row = table.next()) {
    if (row->words[0] != "EDGE_SE2") row->fail("not an EDGE_SE2");
    const OdometryIncrement motion = planar_edge(*row);
    const auto i = static_cast<std::size_t>(row->id(1)), j = static_cast<std::size_t>(row->id(2));
    if (j != i + 1) {
      log.drop("loop closure dropped: only odometry is taken over");
    } else if (i != motions.size()) {
      row->fail(fmt::format("motion from image {}, expected {}", i, motions.size()));
    } else {
      motions.push_back(motion);
    }
  }
  repair_lateral(motions, log);
  return motions;
}

Matrix6d read_covariance(const TextRow& row, double inflate) {
  row.expect_columns(21, 21, "upper triangle of a 6x6 covariance");
  Matrix6d covariance;
  std::size_t column = 0;
  for (Eigen::Index i = 0; i < 6; ++i) {
    for (Eigen::Index j = i; j < 6; ++j) covariance(i, j) = covariance(j, i) = row.number(column++);
  }
  return inflate * inflate * robot_covariance(covariance);
}

/// Motions between consecutive images, in space.
std::vector<OdometryIncrement> read_spatial_odometry(const KittiOptions& options) {
  std::vector<OdometryIncrement> motions;
  std::optional<TextTable> covariances;
  if (!options.covariances.empty()) covariances.emplace(options.covariances);
  Eigen::Matrix<double, 6, 1> variances;
  variances << Eigen::Vector3d::Constant(kSigmaTranslation * kSigmaTranslation),
      Eigen::Vector3d::Constant(kSigmaRotation * kSigmaRotation);
  std::optional<CPose3D> last;
  TextTable table(options.odometry);
  while (const auto row = table.next()) {
    row->expect_columns(12, 12, "a 3x4 matrix");
    const CPose3D pose = robot_pose(*row, 0);
    if (last) {
      Matrix6d covariance = variances.asDiagonal();
      if (covariances) {
        const auto line = covariances->next();
        if (!line) throw Error(fmt::format("{}: ends before the poses do", options.covariances));
        covariance = read_covariance(*line, options.inflate);
      }
      motions.push_back({pose - *last, covariance, false});
    }
    last = pose;
  }
  return motions;
}

std::vector<CPose3D> read_truth(const KittiOptions& options, bool is_3d) {
  std::vector<CPose3D> truth;
  if (options.truth.empty()) return truth;
  TextTable table(options.truth);
  while (const auto row = table.next()) {
    row->expect_columns(12, 12, "a 3x4 matrix");
    const CPose3D pose = robot_pose(*row, 0);
    truth.push_back(is_3d ? pose : flattened(pose));
  }
  return truth;
}

/// Numbers the cars by where the true poses put their sightings, seen from above; those seen often
/// enough become true ids.
void give_true_ids(const KittiOptions& options, const std::vector<CPose3D>& truth,
                   std::vector<BoxSighting>& sightings) {
  std::vector<PlacedSighting> placed;
  for (const BoxSighting& s : sightings) {
    const auto q = truth.at(s.frame).composePoint({s.point.x(), s.point.y(), s.point.z()});
    placed.push_back({{q.x, q.y, 0}});
  }
  const auto numbers = number_by_place(placed, options.oracle_radius, kMinOracleSightings);
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    sightings[i].detection.true_landmark_id = numbers[i];
  }
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
  const bool is_3d = std::filesystem::path(options.odometry).extension() != ".g2o";
  const std::vector<OdometryIncrement> motions =
      is_3d ? read_spatial_odometry(options) : read_planar_odometry(options.odometry, log);
  const std::vector<CPose3D> truth = read_truth(options, is_3d);
  if (!truth.empty() && truth.size() != motions.size() + 1) {
    throw Error(fmt::format("{}: {} true poses, but the odometry has {}", options.truth,
                            truth.size(), motions.size() + 1));
  }
  std::vector<BoxSighting> sightings = read_boxes(options, is_3d, log);
  if (!sightings.empty() && sightings.back().frame > motions.size()) {
    throw Error(fmt::format("{}: has image {}, the odometry ends with {}", options.boxes,
                            sightings.back().frame, motions.size()));
  }
  if (options.oracle_radius > 0) {
    if (truth.empty()) throw Error("an oracle radius needs true poses");
    give_true_ids(options, truth, sightings);
  }
  std::size_t next = 0;
  for (std::size_t i = 0; i <= motions.size(); ++i) {
    ImportedStep step;
    step.time = static_cast<double>(i) * options.period;
    if (i > 0) step.motion = motions[i - 1];
    if (!truth.empty()) step.truth = truth[i];
    auto frame = make_frame(is_3d);
    for (; next < sightings.size() && sightings[next].frame == i; ++next) {
      frame->detections.push_back(sightings[next].detection);
    }
    step.observations.push_back(frame);
    log.add(step);
  }
  return log.finish();
}

}  // namespace hybrid
