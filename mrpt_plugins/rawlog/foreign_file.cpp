// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/foreign_file.h"

#include <algorithm>
#include <utility>

#include "mrpt_plugins/rawlog/byte_io.h"

namespace hybrid {
namespace {

using Kind = std::pair<std::string_view, std::string_view>;  // first bytes, what to say

constexpr Kind kBinary[] = {
    {"\x1f\x8b", "this is compressed twice: decompress it once with gzip -d"},
    {"\x28\xb5\x2f\xfd", "this is compressed twice: decompress it once with zstd -d"},
    {"\xfd\x37zXZ", "this is compressed with xz: decompress it with xz -d first"},
    {"BZh", "this is compressed with bzip2: decompress it with bzip2 -d first"},
    {"\x04\x22\x4d\x18", "this is compressed with lz4: decompress it with lz4 -d first"},
    {"PK\x03\x04", "this is a zip archive: unpack it first"},
    {"7z\xbc\xaf", "this is a 7-Zip archive: unpack it first"},
    {"\x89PNG", "this is a PNG picture"},
    {"\xff\xd8\xff", "this is a JPEG picture"},
    {"GIF8", "this is a GIF picture"},
    {"%PDF-", "this is a PDF document"},
    {"\x7f\x45LF", "this is a program or library: plugins are given with -p"},
    {"\x89HDF", "this is an HDF5 file"},
    {"SQLite format 3", "this is an SQLite database; ros2 bag convert makes MCAP of a ROS bag"},
    {"#ROSBAG V", "this is a ROS bag: rosbag2rawlog converts it"},
    {"\x89MCAP", "this is an MCAP file: examples/ros2/mcap_to_csv.py makes tables of it"},
    {"\xff\xfe", "this is text in UTF-16, not a rawlog"},
};

constexpr Kind kText[] = {
    {"VERTEX", "this is a pose graph: use hybrid-pgo"},
    {"EDGE", "this is a pose graph: use hybrid-pgo"},
    {"FIX ", "this is a pose graph: use hybrid-pgo"},
    {"[", "this is an INI file: give it with -c"},
    {"ply", "this is a point cloud: use hybrid-register"},
    {"VERSION ", "this is a point cloud: use hybrid-register"},
    {"{", "this is JSON, not a rawlog"},
    {"<", "this is XML or HTML, not a rawlog"},
};

bool is_text(std::string_view head) {
  return !head.empty() && (head[0] & 0x80) == 0 &&
         std::all_of(head.begin(), head.end(), [](unsigned char c) {
           return c >= 0x20 || c == '\n' || c == '\r' || c == '\t';
         });
}

/// The first line that is neither blank nor a comment.
std::string_view first_line(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
    if (!line.empty() && line[0] != '#' && line[0] != '%' && !starts_with(line, "//")) return line;
  }
  return {};
}

}  // namespace

std::string foreign_kind(std::string_view head) {
  constexpr std::string_view kMapId = "HMAP";  // of the SQLite database
  constexpr std::size_t kMapIdAt = 68;
  constexpr std::string_view kTarMagic = "ustar";
  constexpr std::size_t kTarMagicAt = 257;
  if (head.size() > kMapIdAt && starts_with(head, "SQLite format 3") &&
      starts_with(head.substr(kMapIdAt), kMapId)) {
    return "this is a map file: give it with --map beside a log, or to hybrid-map";
  }
  for (const auto& [magic, text] : kBinary) {
    if (starts_with(head, magic)) return std::string(text);
  }
  if (head.size() > kTarMagicAt && starts_with(head.substr(kTarMagicAt), kTarMagic)) {
    return "this is a tar archive: unpack it first";
  }
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (starts_with(head, kByteOrderMark)) head.remove_prefix(kByteOrderMark.size());
  if (!is_text(head)) return "";
  const std::string_view line = first_line(head);
  for (const auto& [word, text] : kText) {
    if (starts_with(line, word)) return std::string(text);
  }
  if (line.find(',') != std::string_view::npos) {
    return "this is a table: hybrid-import csv makes a rawlog of tables";
  }
  return "this is text, not a rawlog: hybrid-import csv makes rawlogs of tables";
}

}  // namespace hybrid
