// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-switching/range_log.h"

#include <fmt/format.h>

#include <algorithm>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "libhybrid/io/text_reader.h"

namespace hybrid {
namespace {

AnchorRange range_of(const TextRow& row) {
  const auto v = row.numbers(2, row.size());
  if (v[0] < 0 || v[1] <= 0) row.fail(2, "a range must not be negative, its variance positive");
  const Eigen::Vector2d anchor(row.coordinate(4), row.coordinate(5));
  const auto id = static_cast<int>(row.id(6));
  return {static_cast<int>(row.line()), row.time(1), row.coordinate(2), v[1], anchor, id};
}

WheelSpeeds speeds_of(const TextRow& row) {
  const auto v = row.numbers(2, row.size());
  if (v[3] <= 0 || v[4] <= 0 || v[5] <= 0 || v[6] <= 0) {
    row.fail(5, "base and variances must be positive");
  }
  WheelSpeeds w;
  w.time = row.time(1);
  w.left = row.coordinate(2);
  w.right = row.coordinate(3);
  w.side = row.coordinate(4);
  w.half_base = row.coordinate(5);
  w.variance_left = v[4];
  w.variance_right = v[5];
  w.variance_side = v[6];
  return w;
}

}  // namespace

bool is_range_log(const std::string& path) {
  TextReader text(path);
  const auto row = text.next();
  return row && ((*row)[0] == "range2" || (*row)[0] == "odom2diff");
}

RangeLog read_range_log(const std::string& path) {
  RangeLog log;
  std::size_t range_columns = 0, odometry_columns = 0;
  TextReader table(path);
  while (const auto row = table.next()) {
    if ((*row)[0] == "range2") {
      row->expect_same(range_columns, 7, "range2 time range variance x y anchor");
      log.ranges.push_back(range_of(*row));
    } else if ((*row)[0] == "odom2diff") {
      row->expect_same(
          odometry_columns, 9,
          "odom2diff time v_left v_right v_side half_base var_left var_right var_side");
      log.odometry.push_back(speeds_of(*row));
    } else {
      row->fail(in_quotes((*row)[0]) + " is neither range2 nor odom2diff");
    }
  }
  if (log.ranges.empty() || log.odometry.empty()) {
    throw Error(fmt::format("{}: holds {} ranges and {} rows of odometry; both are needed", path,
                            log.ranges.size(), log.odometry.size()));
  }
  const auto by_time = [](const auto& a, const auto& b) { return a.time < b.time; };
  std::stable_sort(log.ranges.begin(), log.ranges.end(), by_time);
  std::stable_sort(log.odometry.begin(), log.odometry.end(), by_time);
  return log;
}

std::vector<TruePoint> read_true_points(const std::string& path) {
  std::vector<TruePoint> points;
  std::size_t columns = 0;
  TextReader table(path);
  while (const auto row = table.next()) {
    if ((*row)[0] != "point2") row->fail(in_quotes((*row)[0]) + " is not point2");
    row->expect_same(columns, 4, "point2 time x y");
    row->numbers(4, columns);
    points.push_back({row->time(1), {row->coordinate(2), row->coordinate(3)}});
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return points;
}

}  // namespace hybrid
