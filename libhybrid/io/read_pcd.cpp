// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <array>

#include "libhybrid/io/point_text.h"

namespace hybrid {
namespace {

struct Header {
  std::vector<std::string> fields;
  std::vector<std::size_t> counts;  // values of each field; empty: one of each
  std::size_t points = 0;
  bool has_points = false;
};

/// The header up to its DATA line.
Header read_header(PointText& text) {
  Header header;
  std::size_t width = 0, height = 1;
  std::vector<std::string_view> words;
  while (text.next(words)) {
    if (words.empty()) continue;
    const std::string_view what = words[0];
    if (what != "DATA" && words.size() < 2)
      text.fail("'" + std::string(what.substr(0, 40)) + "' has no value");
    if (what == "FIELDS") {
      header.fields.assign(words.begin() + 1, words.end());
    } else if (what == "COUNT") {
      for (std::size_t i = 1; i < words.size(); ++i) header.counts.push_back(text.count(words[i]));
    } else if (what == "WIDTH") {
      width = text.count(words[1]);
    } else if (what == "HEIGHT") {
      height = text.count(words[1]);
    } else if (what == "POINTS") {
      header.points = text.count(words[1]);
      header.has_points = true;
    } else if (what == "DATA") {
      if (words.size() != 2 || words[1] != "ascii") {
        text.fail("only 'DATA ascii' is read; convert the file to text first");
      }
      if (!header.has_points) header.points = width * height;
      return header;
    } else if (what != "VERSION" && what != "SIZE" && what != "TYPE" && what != "VIEWPOINT") {
      text.fail("'" + std::string(what.substr(0, 40)) + "' is not part of a PCD header");
    }
  }
  text.fail("not a PCD file: it has no DATA line");
}

}  // namespace

PointFile read_pcd(PointText& text) {
  const Header header = read_header(text);
  if (!header.counts.empty() && header.counts.size() != header.fields.size()) {
    text.fail("COUNT and FIELDS differ in length");
  }
  std::array<std::size_t, 3> xyz{};
  std::array<bool, 3> found{};
  std::size_t columns = 0;
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (header.fields[i] != std::string(1, "xyz"[axis])) continue;
      xyz[axis] = columns;
      found[axis] = true;
    }
    columns += header.counts.empty() ? 1 : header.counts[i];
  }
  if (!found[0] || !found[1] || !found[2]) text.fail("FIELDS has no x, y and z");
  PointFile file;
  std::vector<std::string_view> words;
  for (std::size_t row = 0; row < header.points;) {
    if (!text.next(words)) {
      text.fail("the header says " + std::to_string(header.points) +
                " points, the file ends after " + std::to_string(row));
    }
    if (words.empty()) continue;
    ++row;
    if (words.size() != columns) {
      text.fail("a point has " + std::to_string(columns) + " values, got " +
                std::to_string(words.size()));
    }
    add_point(file,
              {text.number(words[xyz[0]]), text.number(words[xyz[1]]), text.number(words[xyz[2]])});
  }
  return file;
}

}  // namespace hybrid
