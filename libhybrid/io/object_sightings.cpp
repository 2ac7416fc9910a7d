// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/object_sightings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

struct PoseRows {
  std::vector<double> times;
  std::vector<std::optional<SE3>> poses;
};

/// A row t x y z qx qy qz qw.
using Row = std::array<double, 8>;

Row parse_row(const std::string& line, const std::string& where) {
  std::istringstream text(line);
  Row row{};
  for (double& x : row) {
    if (!(text >> x) || !std::isfinite(x)) {
      throw Error(where + ": expected 8 finite numbers `t x y z qx qy qz qw`");
    }
  }
  std::string more;
  if (text >> more) throw Error(where + ": expected 8 numbers, found more: " + more);
  return row;
}

PoseRows read_rows(const fs::path& path) {
  std::ifstream file(path);
  if (!file) throw Error(path.string() + ": cannot be opened");
  PoseRows rows;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    const std::string where = path.string() + ":" + std::to_string(number);
    const Row row = parse_row(line, where);
    const Eigen::Quaterniond q(row[7], row[4], row[5], row[6]);
    rows.times.push_back(row[0]);
    if (q.norm() == 0.0) {
      rows.poses.emplace_back();
    } else if (std::abs(q.norm() - 1.0) > 1e-2) {
      throw Error(where + ": the quaternion has length " + std::to_string(q.norm()) + ", not 1");
    } else {
      rows.poses.emplace_back(SE3({row[1], row[2], row[3]}, q.normalized()));
    }
  }
  return rows;
}

/// Rows of another file of the sequence, which must be those of odom.txt.
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
  std::error_code failure;
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, failure)) {
    const std::string stem = entry.path().stem().string();
    if (entry.path().extension() == ".txt" && stem.rfind("det_", 0) == 0) {
      names.push_back(stem.substr(4));
    }
  }
  if (failure) throw Error(folder.string() + ": " + failure.message());
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
