// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/point_maps.h"

#include <fmt/format.h>

#include <string_view>

#include "libhybrid/core/error.h"
#include "libhybrid/io/parse_number.h"
#include "libhybrid/io/point_formats.h"
#include "mrpt_plugins/input/rawlog_reader.h"
#include "mrpt_plugins/rawlog/object_reader.h"

namespace hybrid {
namespace {

PointFile points_of(const std::vector<mrpt::math::TPoint3Df>& points, const std::string& path) {
  PointFile file;
  for (const auto& p : points) add_point(file, {p.x, p.y, p.z}, path);
  return file;
}

/// All points of the scans of one step.
PointFile read_step(const std::string& path, std::size_t wanted) {
  RawlogOptions options;
  options.request.points = true;
  RawlogReader reader(path, options);
  std::size_t steps = 0;
  while (const auto step = reader.next()) {
    ++steps;
    if (step->index != wanted) continue;
    if (step->points.empty()) {
      throw Error(fmt::format("{}: step {} has no observation with points", path, wanted));
    }
    return points_of(step->points, path);
  }
  if (!reader.message().empty()) throw Error(reader.message());
  throw Error(fmt::format("{}: has {} steps, step {} was asked for", path, steps, wanted));
}

PointFile read_map(const std::string& path) {
  LogRequest request;
  request.points = true;
  ObjectReader reader(path, request);
  while (const auto object = reader.next()) {
    if (const auto* map = std::get_if<LoggedPoints>(&*object)) return points_of(map->points, path);
  }
  if (reader.status() != LogStatus::kComplete) {
    throw Error(fmt::format(
        "{}; read are .xyz, .txt, .asc, .csv, .ply, .pcd, MRPT's points maps and rawlogs",
        reader.message()));
  }
  throw Error(path + ": holds no points map");
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool is_rawlog(const std::string& path) {
  return ends_with(path, ".rawlog") || ends_with(path, ".rawlog.gz");
}

}  // namespace

PointFile read_point_source(const std::string& path) {
  if (is_point_file(path)) return read_points(path);
  const std::size_t mark = path.rfind('#');
  if (mark != std::string::npos && is_rawlog(path.substr(0, mark))) {
    std::size_t step = 0;
    if (!parse_number(std::string_view(path).substr(mark + 1), step)) {
      throw Error(fmt::format("{}: '#' must be followed by the number of a step", path));
    }
    return read_step(path.substr(0, mark), step);
  }
  PointFile file = is_rawlog(path) ? read_step(path, 0) : read_map(path);
  if (file.points.empty()) throw Error(path + ": holds no point");
  return file;
}

}  // namespace hybrid
