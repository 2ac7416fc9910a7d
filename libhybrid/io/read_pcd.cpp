// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <array>
#include <cstdint>
#include <vector>

#include "libhybrid/io/escaped.h"
#include "libhybrid/io/point_formats.h"

namespace hybrid {
namespace {

constexpr std::int64_t kMostPoints = std::int64_t{1} << 31;
constexpr std::int64_t kMostValues = 1000;  // of a field

struct PcdHeader {
  std::vector<std::string> fields;
  std::vector<std::size_t> counts;  // values of each field; empty: one of each
  std::int64_t points = 0;
  bool has_points = false;
};

/// Reads the header up to its DATA line.
PcdHeader read_pcd_header(TextReader& text) {
  PcdHeader header;
  std::int64_t width = 0, height = 1;
  TextRow row;
  while (text.next(row)) {
    const std::string_view what = row[0];
    if (what != "DATA") row.expect(2, row.size(), std::string(what.substr(0, 40)) + " and a value");
    if (what == "FIELDS") {
      for (std::size_t i = 1; i < row.size(); ++i) header.fields.emplace_back(row[i]);
    } else if (what == "COUNT") {
      for (std::size_t i = 1; i < row.size(); ++i) {
        header.counts.push_back(static_cast<std::size_t>(row.id(i, kMostValues)));
      }
    } else if (what == "WIDTH") {
      width = row.id(1, kMostPoints);
    } else if (what == "HEIGHT") {
      height = row.id(1, kMostPoints);
    } else if (what == "POINTS") {
      header.points = row.id(1, kMostPoints);
      header.has_points = true;
    } else if (what == "DATA") {
      if (row.size() != 2 || row[1] != "ascii") {
        row.fail("only 'DATA ascii' is read; convert the file to text first");
      }
      if (!header.has_points) header.points = width * height;
      return header;
    } else if (what != "VERSION" && what != "SIZE" && what != "TYPE" && what != "VIEWPOINT") {
      row.fail(in_quotes(what) + " is not part of a PCD header");
    }
  }
  text.fail("not a PCD file: it has no DATA line");
}

}  // namespace

PointFile read_pcd(const std::string& path) {
  TextReader text(path, {TextFormat::Cut::kWords, "#"});
  const PcdHeader header = read_pcd_header(text);
  if (!header.counts.empty() && header.counts.size() != header.fields.size()) {
    text.fail("COUNT and FIELDS differ in length");
  }
  std::array<std::size_t, 3> xyz{};
  std::array<bool, 3> found{};
  std::size_t columns = 0;
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    const std::size_t count = header.counts.empty() ? 1 : header.counts[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (count != 1 || header.fields[i] != std::string(1, "xyz"[axis])) continue;
      xyz[axis] = columns;
      found[axis] = true;
    }
    columns += count;
  }
  if (!found[0] || !found[1] || !found[2]) text.fail("FIELDS has no x, y and z");
  PointFile file;
  TextRow row;
  for (std::int64_t read = 0; read < header.points; ++read) {
    if (!text.next(row)) {
      text.fail("the header says " + std::to_string(header.points) +
                " points, the file ends after " + std::to_string(read));
    }
    row.expect(columns, std::to_string(columns) + " values of a point");
    add_point(file, row, xyz);
  }
  if (text.next(row)) {
    row.fail("the header says " + std::to_string(header.points) + " points, but more follow");
  }
  return file;
}

}  // namespace hybrid
