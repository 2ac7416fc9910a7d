// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/kitti_odometry.h"

#include <fmt/format.h>

#include <filesystem>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/import/detail/camera.h"
#include "mrpt_plugins/import/detail/stated_noise.h"

namespace hybrid {
namespace {

constexpr double kSigmaTranslation = 0.03, kSigmaRotation = 0.002;  // m and rad per frame
constexpr const char* kClosure = "loop closure dropped: only odometry is taken over";
constexpr const char* kTurned = "motion repaired: the y of the odometry pointed to the right";

using mrpt::poses::CPose3D;

OdometryIncrement planar_edge(const TextRow& row) {
  Eigen::Matrix3d information;
  std::size_t column = 6;
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = i; j < 3; ++j) {
      information(i, j) = information(j, i) = row.number(column++);
    }
  }
  const Eigen::Matrix3d covariance = information.inverse();
  check_covariance(row, 6, covariance);
  return planar_motion(row.coordinate(3), row.coordinate(4), row.coordinate(5), covariance);
}

/// Whether a line is a motion to the next image rather than a loop closure.
bool is_motion(const TextRow& row) {
  if (row[0] != "EDGE_SE2") row.fail("not an EDGE_SE2");
  row.expect(12, "EDGE_SE2 i j x y angle and 6 numbers of information");
  return row.id(2) == row.id(1) + 1;
}

/// Whether the y axis of the odometry points to the right. The camera is ahead of the rear axle, so
/// that a turn moves it sideways to the inside of the turn; with y to the right the sign is
/// opposite.
bool has_y_to_the_right(const std::string& path) {
  double inwards = 0;
  TextReader table(path);
  while (const auto row = table.next()) {
    if (is_motion(*row)) inwards += row->coordinate(4) * row->coordinate(5);
  }
  return inwards < 0;
}

OdometryIncrement mirrored(const OdometryIncrement& motion) {
  const Eigen::Vector3d mirror(1, -1, 1);
  return planar_motion(motion.mean.x(), -motion.mean.y(), motion.mean.yaw(),
                       mirror.asDiagonal() * planar_part(motion.covariance) * mirror.asDiagonal());
}

Matrix6d read_covariance(const TextRow& row, double inflate) {
  row.expect(21, "upper triangle of a 6x6 covariance");
  Matrix6d covariance;
  std::size_t column = 0;
  for (Eigen::Index i = 0; i < 6; ++i) {
    for (Eigen::Index j = i; j < 6; ++j) covariance(i, j) = covariance(j, i) = row.number(column++);
  }
  check_covariance(row, 0, covariance);
  return inflate * inflate * robot_covariance(covariance);
}

}  // namespace

KittiOdometry::KittiOdometry(const std::string& odometry, const std::string& covariances,
                             double inflate)
    : is_3d_(std::filesystem::path(odometry).extension() != ".g2o"),
      table_(odometry),
      covariances_file_(covariances),
      inflate_(inflate) {
  if (!is_3d_) y_is_right_ = has_y_to_the_right(odometry);
  if (is_3d_ && !covariances.empty()) covariances_.emplace(covariances);
}

std::optional<OdometryIncrement> KittiOdometry::next(DropReport& dropped) {
  auto motion = is_3d_ ? next_in_space() : next_in_plane(dropped);
  if (motion) ++count_;
  return motion;
}

std::optional<OdometryIncrement> KittiOdometry::next_in_plane(DropReport& dropped) {
  while (const auto row = table_.next()) {
    if (!is_motion(*row)) {
      ++dropped[kClosure];
      continue;
    }
    const auto from = static_cast<std::size_t>(row->id(1));
    if (from != count_) row->fail(fmt::format("motion from image {}, expected {}", from, count_));
    const OdometryIncrement motion = planar_edge(*row);
    if (!y_is_right_) return motion;
    ++dropped[kTurned];
    return mirrored(motion);
  }
  return std::nullopt;
}

std::optional<OdometryIncrement> KittiOdometry::next_in_space() {
  const auto read = [&]() -> std::optional<CPose3D> {
    const auto row = table_.next();
    if (!row) return std::nullopt;
    return robot_pose(*row, 0);
  };
  if (!last_) last_ = read();
  const auto pose = read();
  if (!pose) return std::nullopt;
  Matrix6d covariance = Matrix6d::Identity() * kSigmaTranslation * kSigmaTranslation;
  covariance.bottomRightCorner<3, 3>().diagonal().setConstant(kSigmaRotation * kSigmaRotation);
  if (covariances_) {
    const auto line = covariances_->next();
    if (!line) throw Error(fmt::format("{}: ends before the poses do", covariances_file_));
    covariance = read_covariance(*line, inflate_);
  }
  const OdometryIncrement motion{*pose - *last_, covariance, false};
  last_ = pose;
  return motion;
}

}  // namespace hybrid
