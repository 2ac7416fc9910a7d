// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/ground_truth.h"

#include <fmt/format.h>
#include <mrpt/math/CQuaternion.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "libhybrid/io/parse_number.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/bridge/ini_text.h"

namespace hybrid {
namespace {

constexpr std::size_t kBeaconColumns = 12;

std::string class_of(const TextRow& row, const std::vector<std::string>& names) {
  const std::size_t last = row.size() - 1;
  std::uint64_t index = 0;
  if (!parse_number(row[last], index)) return std::string(row[last]);
  if (index < names.size()) return names[index];
  if (names.empty()) {
    row.fail(last, fmt::format("class {}, but no line `% classes: NAME...` names them", index));
  }
  row.fail(last, fmt::format("class {} but only {} classes are named", index, names.size()));
}

Eigen::Vector3d point_of(const TextRow& row, std::size_t i) {
  return {row.coordinate(i), row.coordinate(i + 1), row.coordinate(i + 2)};
}

/// Throws Error where times decrease.
void append(TimedPose pose, const TextRow& row, std::vector<TimedPose>& poses) {
  if (!poses.empty() && pose.time < poses.back().time) {
    row.fail(fmt::format("time {} is before the one above", pose.time));
  }
  poses.push_back(std::move(pose));
}

}  // namespace

std::vector<LandmarkTruth> read_true_landmarks(const std::string& path) {
  std::vector<LandmarkTruth> landmarks;
  std::vector<std::string> class_names;
  std::set<std::int64_t> seen;
  TextReader table(path);
  table.on_comment = [&](std::string_view text) {
    std::vector<std::string> found = ini::words(text);
    if (found.empty() || found.front() != "classes:") return;
    class_names.assign(found.begin() + 1, found.end());
  };
  while (const auto row = table.next()) {
    const bool beacons = row->size() == kBeaconColumns;
    if (!beacons) row->expect(7, 8, "x y z 5 0 0 ID [class], or ID x y z and 8 zeros");
    const std::size_t first = beacons ? 1 : 0;
    LandmarkTruth landmark{row->id(beacons ? 0 : 6), point_of(*row, first), ""};
    row->numbers(3, 6);
    if (row->size() == 8) landmark.class_name = class_of(*row, class_names);
    if (!seen.insert(landmark.id).second) {
      row->fail(beacons ? 0 : 6, fmt::format("landmark {} is listed twice", landmark.id));
    }
    landmarks.push_back(std::move(landmark));
  }
  return landmarks;
}

std::vector<mrpt::poses::CPose3D> read_true_path(const std::string& path) {
  std::vector<mrpt::poses::CPose3D> poses;
  TextReader table(path);
  while (const auto row = table.next()) {
    row->expect(6, "x y z yaw pitch roll (a TUM trajectory is told by a name in .tum)");
    const Eigen::Vector3d p = point_of(*row, 0);
    poses.emplace_back(p.x(), p.y(), p.z(), row->coordinate(3), row->coordinate(4),
                       row->coordinate(5));
  }
  return poses;
}

bool is_numbered_path(const std::string& path) {
  return TextReader(path).next()->size() == 4;
}

std::vector<mrpt::poses::CPose3D> read_numbered_path(const std::string& path) {
  std::vector<mrpt::poses::CPose3D> poses;
  TextReader table(path);
  while (const auto row = table.next()) {
    row->expect(4, "step x y yaw");
    if (row->id(0) != static_cast<std::int64_t>(poses.size())) {
      row->fail(0, fmt::format("step {} is expected here", poses.size()));
    }
    poses.emplace_back(row->coordinate(1), row->coordinate(2), 0, row->coordinate(3), 0, 0);
  }
  return poses;
}

std::vector<TimedPose> read_tum(const std::string& path) {
  std::vector<TimedPose> poses;
  TextReader table(path);
  while (const auto row = table.next()) {
    row->expect(8, "time x y z qx qy qz qw");
    append({row->time(0), pose_in(*row, point_of(*row, 1), {4, 5, 6, 7})}, *row, poses);
  }
  return poses;
}

mrpt::poses::CPose3D pose_in(const TextRow& row, const Eigen::Vector3d& position,
                             const std::array<std::size_t, 4>& quaternion) {
  const auto [i, j, k, l] = quaternion;
  const double x = row.number(i), y = row.number(j), z = row.number(k), w = row.number(l);
  const double norm = std::sqrt(x * x + y * y + z * z + w * w);
  if (std::abs(norm - 1) > 0.01) {
    row.fail(i, fmt::format("quaternion of norm {:.3f}; expected 1", norm));
  }
  const mrpt::math::CQuaternionDouble q(w / norm, x / norm, y / norm, z / norm);
  return {q, position.x(), position.y(), position.z()};
}

bool seems_real_part_first(const std::vector<TimedPose>& poses) {
  constexpr double kUpright = 0.2;           // rad
  constexpr double kMost = 0.9, kFew = 0.5;  // of the poses
  std::size_t upright = 0, upright_if_turned = 0;
  for (const TimedPose& pose : poses) {
    mrpt::math::CQuaternionDouble read;
    pose.pose.getAsQuaternion(read);
    const Eigen::Quaterniond as_read(read.r(), read.x(), read.y(), read.z());
    const Eigen::Quaterniond turned(read.x(), read.y(), read.z(), read.r());
    const auto tilt = [](const Eigen::Quaterniond& q) {
      return std::acos(std::clamp((q * Eigen::Vector3d::UnitZ()).z(), -1.0, 1.0));
    };
    if (tilt(as_read) < kUpright) ++upright;
    if (tilt(turned) < kUpright) ++upright_if_turned;
  }
  const auto count = static_cast<double>(poses.size());
  return static_cast<double>(upright_if_turned) > kMost * count &&
         static_cast<double>(upright) < kFew * count;
}

std::string about_real_part_first(const std::string& path) {
  return path +
         ": read as qx qy qz qw the robot lies on its side; is qw first? With the real part first "
         "it would be upright";
}

std::vector<TimedPose> read_positions(const std::string& path) {
  std::vector<TimedPose> poses;
  TextReader table(path);
  while (const auto row = table.next()) {
    row->expect(4, "time x y z");
    const Eigen::Vector3d p = point_of(*row, 1);
    append({row->time(0), mrpt::poses::CPose3D(p.x(), p.y(), p.z(), 0, 0, 0)}, *row, poses);
  }
  return poses;
}

}  // namespace hybrid
