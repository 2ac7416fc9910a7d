// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/read_points.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>

#include "libhybrid/core/error.h"
#include "libhybrid/io/parse_number.h"
#include "libhybrid/io/point_formats.h"
#include "libhybrid/io/regular_file.h"

namespace hybrid {
namespace {

constexpr std::array<std::string_view, 4> kPlain = {"xyz", "txt", "asc", "csv"};
constexpr std::array<std::string_view, 4> kTimes = {"t", "time", "timestamp", "offset_time"};
constexpr double kNanosecond = 1e-9;
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;  // of a cloud of KITTI
constexpr std::size_t kBytesOfPoint = 16;

std::string extension(const std::string& path) {
  const std::size_t slash = path.find_last_of('/'), dot = path.find_last_of('.');
  if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) return {};
  std::string text = path.substr(dot + 1);
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool is_plain(const std::string& extension) {
  return std::find(kPlain.begin(), kPlain.end(), extension) != kPlain.end();
}

}  // namespace

PointFile read_rows(const std::string& path) {
  TextReader text(path, {TextFormat::Cut::kCells, "#"});
  PointFile file;
  TextRow row;
  std::size_t columns = 0;
  while (text.next(row)) {
    row.expect_same(columns, 3, "x y z, and what else a point has");
    add_point(file, row, {0, 1, 2});
  }
  return file;
}

PointFile read_kitti(const std::string& path) {
  const std::string bytes = read_file(path, kMostBytes);
  if (bytes.size() % kBytesOfPoint != 0) {
    throw Error(
        path + ": " + std::to_string(bytes.size()) +
        " bytes; a cloud of KITTI has 16 for each point (x y z intensity, 32 bits each): is "
        "the file cut off?");
  }
  PointFile file;
  for (std::size_t at = 0; at < bytes.size(); at += kBytesOfPoint) {
    const auto number = [&](std::size_t i) {
      return value_of(&bytes[at + 4 * i], BinaryNumber{4, 'f'}, false);
    };
    add_point(file, {number(0), number(1), number(2)}, path);
  }
  return file;
}

void add_point(PointFile& file, const TextRow& row, const std::array<std::size_t, 3>& xyz) {
  Eigen::Vector3d point;
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t i = xyz[static_cast<std::size_t>(axis)];
    if (!parse_number(row[i], point[axis]) || std::isfinite(point[axis])) {
      point[axis] = row.coordinate(i);
    }
  }
  add_point(file, point, "");
}

void add_point(PointFile& file, const Eigen::Vector3d& point, const std::string& where) {
  if (!point.allFinite()) {
    ++file.left_out;
    return;
  }
  if (point.cwiseAbs().maxCoeff() > kLargestCoordinate) {
    throw Error(where + ": point " + std::to_string(file.points.size() + file.left_out + 1) +
                " has a coordinate beyond 1e15, the largest that is read");
  }
  file.points.push_back(point);
}

bool is_time_field(std::string_view name) {
  return std::find(kTimes.begin(), kTimes.end(), name) != kTimes.end();
}

void add_time(PointFile& file, double value, BinaryNumber type) {
  if (file.times.size() == file.points.size()) return;
  file.times.push_back(type.kind == 'f' ? value : kNanosecond * value);
}

void add_time(PointFile& file, const TextRow& row, std::size_t i, BinaryNumber type) {
  double value = 0;
  if (!parse_number(row[i], value)) value = row.number(i);
  add_time(file, value, type);
}

bool is_point_file(const std::string& path) {
  const std::string kind = extension(path);
  return kind == "ply" || kind == "pcd" || is_plain(kind);
}

PointFile read_cloud(const std::string& path) {
  if (!is_point_file(path)) {
    throw Error(path +
                ": unknown kind of point cloud; .xyz, .txt, .asc, .csv, .ply and .pcd are read");
  }
  const std::string kind = extension(path);
  if (kind == "ply") return read_ply(path);
  return kind == "pcd" ? read_pcd(path) : read_rows(path);
}

PointFile read_points(const std::string& path) {
  PointFile file = read_cloud(path);
  if (file.points.empty()) {
    throw Error(path + (file.left_out > 0 ? ": none of its points is finite" : ": holds no point"));
  }
  return file;
}

}  // namespace hybrid
