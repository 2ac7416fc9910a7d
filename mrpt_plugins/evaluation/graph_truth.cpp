// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/graph_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <optional>

#include "libhybrid/core/error.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/io/text_reader.h"
#include "libhybrid/pose_graph/vertex_id.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/evaluation/ground_truth.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

std::vector<CPose3D> read_planar(const std::string& file) {
  std::vector<CPose3D> poses;
  TextReader text(file);
  while (const auto row = text.next()) {
    row->expect(3, "x y angle");
    poses.emplace_back(row->coordinate(0), row->coordinate(1), 0, row->coordinate(2), 0, 0);
  }
  return poses;
}

std::vector<CPose3D> read_by_id(const std::string& file, const std::vector<Key>& poses) {
  const PoseGraph graph = read_graph(file);
  const Values values = graph.values.empty() ? initialize_from_odometry(graph) : graph.values;
  std::vector<CPose3D> rows;
  for (Key key : poses) {
    if (!values.contains(key)) {
      throw Error(fmt::format("{}: has no pose for vertex {}", file, vertex_name(key.index())));
    }
    rows.push_back(pose_at(values, key));
  }
  return rows;
}

constexpr double kLongestGap = 2.0;  // s, longest interval between true poses that is interpolated

/// All rows `time ...` of a file; times must not decrease.
std::vector<std::vector<double>> read_times(const std::string& file, std::size_t columns,
                                            const char* form) {
  std::vector<std::vector<double>> rows;
  TextReader text(file);
  while (const auto row = text.next()) {
    row->expect(columns, form);
    std::vector<double> numbers = {row->time(0)};
    for (std::size_t i = 1; i < columns; ++i) numbers.push_back(row->coordinate(i));
    if (!rows.empty() && numbers[0] < rows.back()[0]) row->fail("times must rise");
    rows.push_back(std::move(numbers));
  }
  return rows;
}

/// Interpolates linearly between two rows `time x y angle`.
CPose3D interpolate(const std::vector<double>& a, const std::vector<double>& b, double time) {
  const double share = b[0] > a[0] ? (time - a[0]) / (b[0] - a[0]) : 0.0;
  const double turn = std::remainder(b[3] - a[3], 2.0 * M_PI);
  return {a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2]), 0, a[3] + share * turn, 0, 0};
}

std::vector<CPose3D> read_rows(const std::string& file, const std::vector<Key>& poses) {
  TextReader text(file);
  const auto first = text.next();
  if (std::isalpha(static_cast<unsigned char>((*first)[0][0])) != 0) return read_by_id(file, poses);
  if (std::filesystem::path(file).extension() == ".tum") {
    std::vector<CPose3D> rows;
    for (const TimedPose& pose : read_tum(file)) rows.push_back(pose.pose);
    return rows;
  }
  return first->size() == 3 ? read_planar(file) : read_true_path(file);
}

}  // namespace

std::map<Key, CPose3D> read_true_poses(const std::string& file, const std::string& times_file,
                                       const std::vector<Key>& poses) {
  std::map<Key, CPose3D> result;
  if (times_file.empty()) {
    const std::vector<CPose3D> rows = read_rows(file, poses);
    if (rows.size() != poses.size()) {
      throw Error(fmt::format("{}: has {} poses, the graph {}", file, rows.size(), poses.size()));
    }
    for (std::size_t i = 0; i < poses.size(); ++i) result.emplace(poses[i], rows[i]);
    return result;
  }
  const auto rows = read_times(file, 4, "time x y angle");
  const auto times = read_times(times_file, 1, "time");
  if (times.size() != poses.size()) {
    throw Error(fmt::format("{}: has {} times, the graph {} poses", times_file, times.size(),
                            poses.size()));
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double time = times[i][0];
    const auto after = std::lower_bound(rows.begin(), rows.end(), time,
                                        [](const auto& row, double t) { return row[0] < t; });
    if (after == rows.begin() || after == rows.end()) continue;
    if ((*after)[0] - (*(after - 1))[0] > kLongestGap) continue;
    result.emplace(poses[i], interpolate(*(after - 1), *after, time));
  }
  if (result.empty())
    throw Error(fmt::format("{}: no true pose at any time of {}", file, times_file));
  return result;
}

std::vector<PosePair> pair_with_truth(const std::map<Key, CPose3D>& truth, const Values& estimate) {
  std::vector<PosePair> pairs;
  std::optional<CPose3D> motion;
  for (const auto& [key, pose] : truth) {
    if (!estimate.contains(key)) continue;
    const CPose3D estimated = pose_at(estimate, key);
    if (!motion) motion = estimated + (CPose3D() - pose);
    pairs.push_back({estimated, *motion + pose});
  }
  return pairs;
}

}  // namespace hybrid
