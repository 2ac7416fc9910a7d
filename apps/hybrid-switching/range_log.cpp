// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-switching/range_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

/// The numbers of a row, of which there must be at least `least`, all finite.
std::vector<double> numbers(std::istringstream& row, std::size_t least, const std::string& where) {
  std::vector<double> out;
  std::string word;
  while (row >> word) {
    std::size_t used = 0;
    double value = 0;
    try {
      value = std::stod(word, &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (used != word.size() || !std::isfinite(value)) {
      throw Error(fmt::format("{}: '{}' is not a finite number", where, word));
    }
    out.push_back(value);
  }
  if (out.size() < least) {
    throw Error(fmt::format("{}: {} numbers, at least {} are needed", where, out.size(), least));
  }
  return out;
}

/// Calls row(kind, words, line number, place) for every row of a file that is not empty.
template <class Row>
void for_each_row(const std::string& path, Row&& row) {
  std::ifstream file(path);
  if (!file) throw Error(fmt::format("cannot read {}", path));
  std::string line;
  for (int n = 1; std::getline(file, line); ++n) {
    std::istringstream words(line);
    std::string kind;
    if (words >> kind) row(kind, words, n, fmt::format("{}:{}", path, n));
  }
}

}  // namespace

bool is_range_log(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Error(fmt::format("cannot read {}", path));
  std::string word;
  file >> word;
  return word == "range2" || word == "odom2diff";
}

RangeLog read_range_log(const std::string& path) {
  RangeLog log;
  for_each_row(path, [&](const std::string& kind, std::istringstream& words, int line,
                         const std::string& where) {
    if (kind == "range2") {
      const auto v = numbers(words, 6, where);
      if (v[1] < 0 || v[2] <= 0) {
        throw Error(fmt::format("{}: a range must not be negative, its variance positive", where));
      }
      log.ranges.push_back({line, v[0], v[1], v[2], {v[3], v[4]}, static_cast<int>(v[5])});
    } else if (kind == "odom2diff") {
      const auto v = numbers(words, 8, where);
      if (v[4] <= 0 || v[5] <= 0 || v[6] <= 0 || v[7] <= 0) {
        throw Error(fmt::format("{}: base and variances must be positive", where));
      }
      log.odometry.push_back({v[0], v[1], v[2], v[4], v[5], v[6], v[7]});
    } else {
      throw Error(fmt::format("{}: '{}' is neither range2 nor odom2diff", where, kind));
    }
  });
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
  for_each_row(
      path, [&](const std::string& kind, std::istringstream& words, int, const std::string& where) {
        if (kind != "point2") throw Error(fmt::format("{}: '{}' is not point2", where, kind));
        const auto v = numbers(words, 3, where);
        points.push_back({v[0], {v[1], v[2]}});
      });
  if (points.empty()) throw Error(fmt::format("{}: holds no point", path));
  std::stable_sort(points.begin(), points.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return points;
}

}  // namespace hybrid
