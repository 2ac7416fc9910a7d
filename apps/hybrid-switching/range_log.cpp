// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-switching/range_log.h"

#include <fmt/format.h>

#include <algorithm>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/input/text_table.h"

namespace hybrid {
namespace {

/// The numbers of a row behind its first word, of which there must be at least `least`.
std::vector<double> numbers(const TextRow& row, std::size_t least) {
  std::vector<double> out = row.numbers(1);
  if (out.size() < least) {
    row.fail(fmt::format("{} numbers, at least {} are needed", out.size(), least));
  }
  return out;
}

}  // namespace

bool is_range_log(const std::string& path) {
  const auto row = TextTable(path).next();
  return row && (row->words[0] == "range2" || row->words[0] == "odom2diff");
}

RangeLog read_range_log(const std::string& path) {
  RangeLog log;
  TextTable table(path);
  while (const auto row = table.next()) {
    const std::string& kind = row->words[0];
    if (kind == "range2") {
      const auto v = numbers(*row, 6);
      if (v[1] < 0 || v[2] <= 0) row->fail("a range must not be negative, its variance positive");
      const int line = static_cast<int>(row->line);
      const int anchor = static_cast<int>(row->id(6));
      log.ranges.push_back({line, v[0], v[1], v[2], {v[3], v[4]}, anchor});
    } else if (kind == "odom2diff") {
      const auto v = numbers(*row, 8);
      if (v[4] <= 0 || v[5] <= 0 || v[6] <= 0 || v[7] <= 0) {
        row->fail("base and variances must be positive");
      }
      log.odometry.push_back({v[0], v[1], v[2], v[4], v[5], v[6], v[7]});
    } else {
      row->fail(fmt::format("'{}' is neither range2 nor odom2diff", kind));
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
  TextTable table(path);
  while (const auto row = table.next()) {
    if (row->words[0] != "point2") row->fail(fmt::format("'{}' is not point2", row->words[0]));
    const auto v = numbers(*row, 3);
    points.push_back({v[0], {v[1], v[2]}});
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return points;
}

}  // namespace hybrid
