// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/pose_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libhybrid/core/error.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/io/text_reader.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/evaluation/ground_truth.h"
#include "mrpt_plugins/import/detail/camera.h"

namespace hybrid {
namespace {

constexpr std::size_t kTum = 8, kKitti = 12, kMatrix = 16, kNumberedMatrix = 17, kMatrixLine = 4;
constexpr const char* kForms =
    "8 columns (TUM: time x y z qx qy qz qw), 12 (KITTI: a 3x4 matrix), 16 (a 4x4 matrix), 17 (a "
    "number and a 4x4 matrix), or four rows of 4 (a 4x4 matrix), or they are those of a g2o file";

/// Columns of a row without an empty one behind a comma at its end.
std::size_t columns_of(const TextRow& row) {
  const std::size_t size = row.size();
  return size > 1 && row[size - 1].empty() ? size - 1 : size;
}

void expect_columns(const TextRow& row, std::size_t count) {
  const std::size_t columns = columns_of(row);
  if (columns == count) return;
  row.fail(std::min(columns, count),
           fmt::format("{} columns; {} are expected, as in the rows above", columns, count));
}

/// The last row of a homogeneous matrix up to its last number, which is returned.
double last_of_matrix(const TextRow& row, std::size_t first) {
  constexpr double kRounding = 1e-6;
  for (std::size_t i = first; i < first + 3; ++i) {
    if (std::abs(row.number(i)) > kRounding) {
      row.fail(i, "the last row of a 4x4 matrix begins with 0 0 0");
    }
  }
  return row.number(first + 3);
}

/// A 4x4 matrix in four rows, of which the first has been read.
PoseRow pose_in_four_rows(TextReader& table, TextRow& row) {
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
  for (Eigen::Index r = 0; r < 3; ++r) {
    expect_columns(row, kMatrixLine);
    for (Eigen::Index c = 0; c < 3; ++c) R(r, c) = row.number(static_cast<std::size_t>(c));
    t[r] = row.coordinate(3);
    if (!table.next(row)) table.fail("the file ends within a matrix of four rows");
  }
  expect_columns(row, kMatrixLine);
  last_of_matrix(row, 0);
  return {row.time(3), matrix_pose(R, t, row, 0)};
}

PoseRow pose_in_one_row(const TextRow& row, std::size_t columns) {
  expect_columns(row, columns);
  const std::size_t first = columns == kNumberedMatrix ? 1 : 0;
  if (first == 1) row.number(0);
  if (columns != kKitti && last_of_matrix(row, first + 12) != 1) {
    row.fail(first + 15, "the last number of a 4x4 matrix is 1");
  }
  return {std::nullopt, matrix_pose(row, first)};
}

std::vector<PoseRow> read_tum_rows(const std::string& path) {
  std::vector<PoseRow> poses;
  for (const TimedPose& timed : read_tum(path)) poses.push_back({timed.time, timed.pose});
  return poses;
}

bool is_of_g2o(std::string_view word) {
  return word.substr(0, 7) == "VERTEX_" || word.substr(0, 5) == "EDGE_";
}

std::vector<PoseRow> read_graph_rows(const std::string& path) {
  const PoseGraph graph = hybrid::read_graph(path);
  if (graph.poses3.empty()) throw Error(path + ": has no edges between poses in space");
  const Values poses = initialize_from_odometry(graph);
  std::vector<PoseRow> rows;
  std::vector<Key> keys = poses.keys();
  std::sort(keys.begin(), keys.end());
  for (const Key key : keys) {
    if (poses.type(key) != Variable<SE3>::type()) continue;
    rows.push_back({std::nullopt, to_mrpt(to_isometry(poses.at<SE3>(key)))});
  }
  return rows;
}

}  // namespace

std::vector<PoseRow> read_pose_rows(const std::string& path) {
  TextReader table(path);
  TextRow row = table.next().value();
  if (is_of_g2o(row[0])) return read_graph_rows(path);
  const std::size_t columns = columns_of(row);
  if (columns == kTum) return read_tum_rows(path);
  if (columns != kKitti && columns != kMatrix && columns != kNumberedMatrix &&
      columns != kMatrixLine) {
    row.fail(fmt::format("{} columns; poses have {}", columns, kForms));
  }
  std::vector<PoseRow> poses;
  bool are_times = false;
  do {
    poses.push_back(columns == kMatrixLine ? pose_in_four_rows(table, row)
                                           : pose_in_one_row(row, columns));
    are_times = are_times || (columns == kMatrixLine && poses.back().time != 1);
    const std::size_t count = poses.size();
    if (are_times && count > 1 && poses[count - 1].time < poses[count - 2].time) {
      row.fail(3, fmt::format("time {} is before that of the matrix above", *poses.back().time));
    }
  } while (table.next(row));
  if (!are_times) {
    for (PoseRow& pose : poses) pose.time.reset();
  }
  return poses;
}

}  // namespace hybrid
