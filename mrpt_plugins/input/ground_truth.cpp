// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/ground_truth.h"

#include <fmt/format.h>
#include <mrpt/math/CQuaternion.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <set>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/ini_text.h"

namespace hybrid {
namespace {

/// A row of a table and its place for messages.
struct Row {
  std::string where;
  std::vector<std::string> words;

  double number(std::size_t column) const {
    double value = 0;
    if (ini::parse(words[column], value)) return value;
    throw Error(fmt::format("{}: column {}: '{}' is not a finite number", where, column + 1,
                            words[column]));
  }
  void expect_columns(std::size_t min, std::size_t max, const char* form) const {
    if (words.size() >= min && words.size() <= max) return;
    throw Error(fmt::format("{}: {} columns; expected: {}", where, words.size(), form));
  }
};

/// Calls `take` with every row, and `comment` with every comment.
void read_rows(
    const std::string& path, const std::function<void(const Row&)>& take,
    const std::function<void(const std::string&)>& comment = [](const std::string&) {}) {
  std::ifstream file(path);
  if (!file) throw Error(fmt::format("{}: no such file, or not readable", path));
  std::size_t rows = 0, number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    const std::size_t mark = line.find_first_of("%#");
    if (mark != std::string::npos) comment(line.substr(mark + 1));
    Row row{fmt::format("{}:{}", path, number), ini::words(line.substr(0, mark))};
    if (row.words.empty()) continue;
    take(row);
    ++rows;
  }
  if (rows == 0) throw Error(fmt::format("{}: holds no row", path));
}

std::int64_t whole_number(const Row& row, std::size_t column) {
  const double value = row.number(column);
  if (std::floor(value) == value && value >= 0 && value < 1e15) {
    return static_cast<std::int64_t>(value);
  }
  throw Error(
      fmt::format("{}: column {}: '{}' is not an id", row.where, column + 1, row.words[column]));
}

std::string class_of(const Row& row, const std::vector<std::string>& names) {
  const std::string& word = row.words.back();
  std::uint64_t index = 0;
  if (names.empty() || !ini::parse(word, index)) return word;
  if (index < names.size()) return names[index];
  throw Error(
      fmt::format("{}: class {} but only {} classes are named", row.where, index, names.size()));
}

}  // namespace

std::vector<LandmarkTruth> read_true_landmarks(const std::string& path) {
  std::vector<LandmarkTruth> landmarks;
  std::vector<std::string> class_names;
  std::set<std::int64_t> seen;
  const auto take = [&](const Row& row) {
    row.expect_columns(7, 8, "x y z 5 0 0 ID [class]");
    LandmarkTruth landmark{whole_number(row, 6), {row.number(0), row.number(1), row.number(2)}, ""};
    for (std::size_t i = 3; i < 6; ++i) row.number(i);
    if (row.words.size() == 8) landmark.class_name = class_of(row, class_names);
    if (!seen.insert(landmark.id).second) {
      throw Error(fmt::format("{}: landmark {} is listed twice", row.where, landmark.id));
    }
    landmarks.push_back(std::move(landmark));
  };
  const auto comment = [&](const std::string& text) {
    std::vector<std::string> found = ini::words(text);
    if (found.empty() || found.front() != "classes:") return;
    class_names.assign(found.begin() + 1, found.end());
  };
  read_rows(path, take, comment);
  return landmarks;
}

std::vector<mrpt::poses::CPose3D> read_true_path(const std::string& path) {
  std::vector<mrpt::poses::CPose3D> poses;
  read_rows(path, [&](const Row& row) {
    row.expect_columns(6, 6, "x y z yaw pitch roll");
    poses.emplace_back(row.number(0), row.number(1), row.number(2), row.number(3), row.number(4),
                       row.number(5));
  });
  return poses;
}

std::vector<TimedPose> read_tum(const std::string& path) {
  std::vector<TimedPose> poses;
  read_rows(path, [&](const Row& row) {
    row.expect_columns(8, 8, "time x y z qx qy qz qw");
    const double x = row.number(4), y = row.number(5), z = row.number(6), w = row.number(7);
    const double norm = std::sqrt(x * x + y * y + z * z + w * w);
    if (std::abs(norm - 1) > 0.01) {
      throw Error(fmt::format("{}: quaternion of norm {:.3f}; expected 1", row.where, norm));
    }
    const double time = row.number(0);
    if (!poses.empty() && time < poses.back().time) {
      throw Error(fmt::format("{}: time {} is before the one above", row.where, row.words[0]));
    }
    const mrpt::math::CQuaternionDouble q(w / norm, x / norm, y / norm, z / norm);
    poses.push_back({time, mrpt::poses::CPose3D(q, row.number(1), row.number(2), row.number(3))});
  });
  return poses;
}

}  // namespace hybrid
