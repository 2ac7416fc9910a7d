// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/read_points.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "libhybrid/core/error.h"
#include "libhybrid/io/point_text.h"

namespace hybrid {
namespace {

constexpr std::array<std::string_view, 4> kPlain = {"xyz", "txt", "asc", "csv"};

std::string extension(const std::string& path) {
  const std::size_t slash = path.find_last_of('/'), dot = path.find_last_of('.');
  if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) return {};
  std::string text = path.substr(dot + 1);
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool is_plain(const std::string& extension) {
  return std::find(kPlain.begin(), kPlain.end(), extension) != kPlain.end();
}

PointFile read_rows(PointText& text) {
  PointFile file;
  std::vector<std::string_view> words;
  while (text.next(words)) {
    if (words.empty()) continue;
    if (words.size() < 3) {
      text.fail("a point needs 3 numbers, got " + std::to_string(words.size()));
    }
    add_point(file, {text.number(words[0]), text.number(words[1]), text.number(words[2])});
  }
  return file;
}

}  // namespace

bool PointText::next(std::vector<std::string_view>& words) {
  words.clear();
  if (rest_.empty()) return false;
  ++line_;
  const std::size_t end = std::min(rest_.find('\n'), rest_.size());
  std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  line = line.substr(0, line.find('#'));
  constexpr std::string_view kBetween = " \t\r,;";
  while (true) {
    const std::size_t first = line.find_first_not_of(kBetween);
    if (first == std::string_view::npos) return true;
    line.remove_prefix(first);
    const std::size_t length = std::min(line.find_first_of(kBetween), line.size());
    words.push_back(line.substr(0, length));
    line.remove_prefix(length);
  }
}

double PointText::number(std::string_view word) const {
  const char* first = word.data() + (word.size() > 1 && word[0] == '+' && word[1] != '-');
  double value = 0.0;
  const auto [end, error] = std::from_chars(first, word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) {
    fail("'" + std::string(word.substr(0, 40)) + "' is not a number");
  }
  return value;
}

std::size_t PointText::count(std::string_view word) const {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) {
    fail("'" + std::string(word.substr(0, 40)) + "' is not a count");
  }
  return value;
}

void PointText::fail(const std::string& what) const {
  throw Error(file_ + ":" + std::to_string(line_) + ": " + what);
}

void add_point(PointFile& file, const Eigen::Vector3d& point) {
  if (point.allFinite()) {
    file.points.push_back(point);
  } else {
    ++file.left_out;
  }
}

bool is_point_file(const std::string& path) {
  const std::string kind = extension(path);
  return kind == "ply" || kind == "pcd" || is_plain(kind);
}

PointFile read_points(const std::string& path) {
  if (!is_point_file(path)) {
    throw Error(path +
                ": unknown kind of point cloud; .xyz, .txt, .asc, .csv, .ply and .pcd are read");
  }
  std::ifstream in(path, std::ios::binary);
  if (!in || std::filesystem::is_directory(path)) throw Error(path + ": cannot be read");
  const std::string content{std::istreambuf_iterator<char>(in), {}};
  PointText text(content, path);
  const std::string kind = extension(path);
  PointFile file = kind == "ply"   ? read_ply(text)
                   : kind == "pcd" ? read_pcd(text)
                                   : read_rows(text);
  if (file.points.empty()) {
    throw Error(path + (file.left_out > 0 ? ": none of its points is finite" : ": holds no point"));
  }
  return file;
}

}  // namespace hybrid
