// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/ground_truth.h"

#include <fmt/format.h>
#include <mrpt/math/CQuaternion.h>

#include <cmath>
#include <set>
#include <utility>

#include "mrpt_plugins/bridge/ini_text.h"
#include "mrpt_plugins/input/text_table.h"

namespace hybrid {
namespace {

constexpr std::size_t kBeaconColumns = 12;

std::string class_of(const TextRow& row, const std::vector<std::string>& names) {
  const std::string& word = row.words.back();
  std::uint64_t index = 0;
  if (names.empty() || !ini::parse(word, index)) return word;
  if (index < names.size()) return names[index];
  row.fail(fmt::format("class {} but only {} classes are named", index, names.size()));
}

/// Throws Error where times go backwards.
void append(TimedPose pose, const TextRow& row, std::vector<TimedPose>& poses) {
  if (!poses.empty() && pose.time < poses.back().time) {
    row.fail(fmt::format("time {} is before the one above", row.words[0]));
  }
  poses.push_back(std::move(pose));
}

}  // namespace

std::vector<LandmarkTruth> read_true_landmarks(const std::string& path) {
  std::vector<LandmarkTruth> landmarks;
  std::vector<std::string> class_names;
  std::set<std::int64_t> seen;
  TextTable table(path);
  table.on_comment = [&](const std::string& text) {
    std::vector<std::string> found = ini::words(text);
    if (found.empty() || found.front() != "classes:") return;
    class_names.assign(found.begin() + 1, found.end());
  };
  while (const auto row = table.next()) {
    const bool beacons = row->words.size() == kBeaconColumns;
    if (!beacons) row->expect_columns(7, 8, "x y z 5 0 0 ID [class], or ID x y z and 8 zeros");
    const std::size_t first = beacons ? 1 : 0;
    LandmarkTruth landmark{row->id(beacons ? 0 : 6),
                           {row->number(first), row->number(first + 1), row->number(first + 2)},
                           ""};
    for (std::size_t i = 3; i < 6; ++i) row->number(i);
    if (row->words.size() == 8) landmark.class_name = class_of(*row, class_names);
    if (!seen.insert(landmark.id).second) {
      row->fail(fmt::format("landmark {} is listed twice", landmark.id));
    }
    landmarks.push_back(std::move(landmark));
  }
  return landmarks;
}

std::vector<mrpt::poses::CPose3D> read_true_path(const std::string& path) {
  std::vector<mrpt::poses::CPose3D> poses;
  TextTable table(path);
  while (const auto row = table.next()) {
    row->expect_columns(6, 6, "x y z yaw pitch roll");
    poses.emplace_back(row->number(0), row->number(1), row->number(2), row->number(3),
                       row->number(4), row->number(5));
  }
  return poses;
}

std::vector<TimedPose> read_tum(const std::string& path) {
  std::vector<TimedPose> poses;
  TextTable table(path);
  while (const auto row = table.next()) {
    row->expect_columns(8, 8, "time x y z qx qy qz qw");
    const double x = row->number(4), y = row->number(5), z = row->number(6), w = row->number(7);
    const double norm = std::sqrt(x * x + y * y + z * z + w * w);
    if (std::abs(norm - 1) > 0.01) {
      row->fail(fmt::format("quaternion of norm {:.3f}; expected 1", norm));
    }
    const mrpt::math::CQuaternionDouble q(w / norm, x / norm, y / norm, z / norm);
    append(
        {row->number(0), mrpt::poses::CPose3D(q, row->number(1), row->number(2), row->number(3))},
        *row, poses);
  }
  return poses;
}

std::vector<TimedPose> read_positions(const std::string& path) {
  std::vector<TimedPose> poses;
  TextTable table(path);
  while (const auto row = table.next()) {
    row->expect_columns(4, 4, "time x y z");
    append({row->number(0),
            mrpt::poses::CPose3D(row->number(1), row->number(2), row->number(3), 0, 0, 0)},
           *row, poses);
  }
  return poses;
}

}  // namespace hybrid
