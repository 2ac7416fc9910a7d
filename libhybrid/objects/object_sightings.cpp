// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/objects/object_sightings.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "libhybrid/core/error.h"
#include "libhybrid/io/folders.h"
#include "libhybrid/io/text_reader.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

struct PoseRows {
  std::vector<double> times;
  std::vector<std::optional<SE3>> poses;
};

PoseRows read_rows(const fs::path& path) {
  TextReader text(path.string());
  PoseRows rows;
  while (const auto row = text.next()) {
    row->expect(8, "t x y z qx qy qz qw");
    rows.times.push_back(row->time(0));
    const Eigen::Vector3d position(row->coordinate(1), row->coordinate(2), row->coordinate(3));
    const Eigen::Quaterniond q(row->number(7), row->number(4), row->number(5), row->number(6));
    const double norm = q.norm();
    if (norm == 0.0) {
      rows.poses.emplace_back();
    } else if (std::abs(norm - 1.0) > 1e-2) {
      row->fail(4, "the quaternion has length " + std::to_string(norm) + ", not 1");
    } else {
      rows.poses.emplace_back(SE3(position, q.normalized()));
    }
  }
  return rows;
}

/// Rows of another file of the sequence; their times must be those of odom.txt.
std::vector<std::optional<SE3>> read_track(const fs::path& path, const std::vector<double>& times) {
  PoseRows rows = read_rows(path);
  if (rows.times.size() != times.size()) {
    throw Error(path.string() + ": has " + std::to_string(rows.times.size()) +
                " rows, odom.txt has " + std::to_string(times.size()) +
                "; there must be one per frame");
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (std::abs(rows.times[i] - times[i]) > 1e-3) {
      throw Error(path.string() + ": row " + std::to_string(i + 1) + " is of time " +
                  std::to_string(rows.times[i]) + ", in odom.txt of " + std::to_string(times[i]));
    }
  }
  return std::move(rows.poses);
}

std::vector<SE3> all_of(const std::vector<std::optional<SE3>>& poses, const fs::path& path) {
  std::vector<SE3> all;
  for (const std::optional<SE3>& pose : poses) {
    if (!pose) {
      throw Error(path.string() + ": row " + std::to_string(all.size() + 1) +
                  " has no orientation; every frame needs a camera pose");
    }
    all.push_back(*pose);
  }
  return all;
}

std::vector<std::string> object_names(const fs::path& folder) {
  if (!name_exists(folder)) throw Error(folder.string() + ": no such folder");
  std::vector<std::string> names;
  for (const FolderEntry& entry : entries_of(folder)) {
    const fs::path file(entry.name);
    const std::string stem = file.stem().string();
    if (file.extension() == ".txt" && stem.rfind("det_", 0) == 0) names.push_back(stem.substr(4));
  }
  if (names.empty()) throw Error(folder.string() + ": holds no sightings (det_NAME.txt)");
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

ObjectSequence read_object_sequence(const std::string& folder) {
  const fs::path path(folder);
  const std::vector<std::string> names = object_names(path);
  PoseRows odometry = read_rows(path / "odom.txt");
  ObjectSequence sequence;
  sequence.odometry = all_of(odometry.poses, path / "odom.txt");
  if (sequence.odometry.empty()) throw Error((path / "odom.txt").string() + ": holds no poses");
  sequence.times = std::move(odometry.times);
  if (const fs::path truth = path / "cam_gt.txt"; fs::exists(truth)) {
    sequence.truth = all_of(read_track(truth, sequence.times), truth);
  }
  for (const std::string& name : names) {
    ObjectTrack track;
    track.name = name;
    track.sightings = read_track(path / ("det_" + name + ".txt"), sequence.times);
    if (const fs::path truth = path / ("objgt_" + name + ".txt"); fs::exists(truth)) {
      track.truth = read_track(truth, sequence.times);
    }
    sequence.objects.push_back(std::move(track));
  }
  return sequence;
}

}  // namespace hybrid
