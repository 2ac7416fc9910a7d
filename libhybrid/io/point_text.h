// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "libhybrid/io/read_points.h"

namespace hybrid {

/// The text of a point file, line by line, with errors that say where.
class PointText {
 public:
  PointText(std::string_view text, std::string file) : rest_(text), file_(std::move(file)) {}

  /// The words of the next line, separated by blanks, commas or semicolons, comments removed; false
  /// at the end of the file.
  bool next(std::vector<std::string_view>& words);
  int line() const { return line_; }
  /// What follows the lines read, for binary data after a text header.
  std::string_view rest() const { return rest_; }

  double number(std::string_view word) const;
  std::size_t count(std::string_view word) const;
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string_view rest_;
  std::string file_;
  int line_ = 0;
};

/// Adds a point, or counts it where it is not finite.
void add_point(PointFile& file, const Eigen::Vector3d& point);

PointFile read_ply(PointText& text);
PointFile read_pcd(PointText& text);

}  // namespace hybrid
