// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "libhybrid/io/binary_number.h"
#include "libhybrid/io/escaped.h"
#include "libhybrid/io/point_formats.h"

namespace hybrid {
namespace {

constexpr std::int64_t kMostRows = std::int64_t{1} << 31;  // of an element

enum class Encoding { kText, kLittleEndian, kBigEndian };

struct Property {
  std::string name;
  BinaryNumber type;
  BinaryNumber length;  // of a list; no bytes for a single value
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

struct PlyHeader {
  Encoding encoding = Encoding::kText;
  std::vector<Element> elements;
};

BinaryNumber scalar(const TextRow& row, std::size_t i) {
  static constexpr std::pair<std::string_view, BinaryNumber> kTypes[] = {
      {"char", {1, 'i'}},  {"int8", {1, 'i'}},    {"uchar", {1, 'u'}},  {"uint8", {1, 'u'}},
      {"short", {2, 'i'}}, {"int16", {2, 'i'}},   {"ushort", {2, 'u'}}, {"uint16", {2, 'u'}},
      {"int", {4, 'i'}},   {"int32", {4, 'i'}},   {"uint", {4, 'u'}},   {"uint32", {4, 'u'}},
      {"float", {4, 'f'}}, {"float32", {4, 'f'}}, {"double", {8, 'f'}}, {"float64", {8, 'f'}}};
  for (const auto& [known, type] : kTypes) {
    if (row[i] == known) return type;
  }
  row.fail(i, in_quotes(row[i]) + " is not a type of PLY");
}

void read_property(const TextRow& row, PlyHeader& header) {
  if (header.elements.empty()) row.fail("a property before the first element");
  const bool list = row.size() == 5 && row[1] == "list";
  if (!list) row.expect(3, "property TYPE NAME");
  Property property;
  property.name = std::string(row[row.size() - 1]);
  property.type = scalar(row, row.size() - 2);
  if (list) property.length = scalar(row, 2);
  if (list && property.length.kind == 'f') row.fail(2, "the length of a list is no whole number");
  header.elements.back().properties.push_back(property);
}

Encoding encoding(const TextRow& row) {
  if (row[1] == "ascii") return Encoding::kText;
  if (row[1] == "binary_little_endian") return Encoding::kLittleEndian;
  if (row[1] == "binary_big_endian") return Encoding::kBigEndian;
  row.fail(1, "unknown format " + in_quotes(row[1]));
}

PlyHeader read_ply_header(TextReader& text) {
  TextRow row;
  if (!text.next(row) || row.size() != 1 || row[0] != "ply") {
    text.fail("not a PLY file: it does not begin with 'ply'");
  }
  PlyHeader header;
  bool format = false;
  while (text.next(row)) {
    if (row[0] == "comment" || row[0] == "obj_info") continue;
    if (row[0] == "end_header") {
      if (!format) row.fail("the header has no 'format' line");
      return header;
    }
    if (row[0] == "format" && row.size() == 3) {
      format = true;
      header.encoding = encoding(row);
    } else if (row[0] == "element" && row.size() == 3) {
      header.elements.push_back({std::string(row[1]), row.id(2, kMostRows), {}});
    } else if (row[0] == "property") {
      read_property(row, header);
    } else {
      row.fail(in_quotes(row[0]) + " is not part of a PLY header");
    }
  }
  text.fail("the file ends inside the header");
}

/// The indices of the properties x, y and z of an element.
std::array<std::size_t, 3> coordinates(const TextReader& text, const Element& element) {
  std::array<std::size_t, 3> places{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name(1, "xyz"[axis]);
    std::size_t i = 0;
    while (i < element.properties.size() && element.properties[i].name != name) ++i;
    if (i == element.properties.size() || element.properties[i].length.bytes != 0) {
      text.fail("the vertices have no property '" + name + "'");
    }
    places[axis] = i;
  }
  return places;
}

/// The property that holds the time of a vertex, if there is one.
std::optional<std::size_t> time_property(const Element& element) {
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const Property& property = element.properties[i];
    if (property.length.bytes == 0 && is_time_field(property.name)) return i;
  }
  return std::nullopt;
}

[[noreturn]] void fail_short(const TextReader& text, const Element& element, std::int64_t read) {
  text.fail("the header says " + std::to_string(element.count) + " of element " +
            in_quotes(element.name) + ", the file ends after " + std::to_string(read));
}

/// The index of the first word of each property of a row, then the number of words; lists begin
/// with their length.
std::vector<std::size_t> first_words(const TextRow& row, const Element& element) {
  std::vector<std::size_t> first = {0};
  for (const Property& property : element.properties) {
    std::size_t words = 1;
    if (property.length.bytes > 0 && first.back() < row.size()) {
      words += static_cast<std::size_t>(row.id(first.back()));
    }
    first.push_back(first.back() + words);
  }
  return first;
}

void read_text(TextReader& text, const Element& element, PointFile* file) {
  const std::array<std::size_t, 3> xyz =
      file != nullptr ? coordinates(text, element) : std::array<std::size_t, 3>{};
  const std::optional<std::size_t> time = time_property(element);
  if (element.properties.empty()) return;
  TextRow row;
  for (std::int64_t read = 0; read < element.count; ++read) {
    if (!text.next(row)) fail_short(text, element, read);
    const std::vector<std::size_t> first = first_words(row, element);
    row.expect(first.back(),
               std::to_string(first.back()) + " values of element " + in_quotes(element.name));
    if (file == nullptr) continue;
    add_point(*file, row, {first[xyz[0]], first[xyz[1]], first[xyz[2]]});
    if (time) add_time(*file, row, first[*time], element.properties[*time].type);
  }
}

/// Reads a value of binary data; false at the end of the file.
bool take(TextReader& data, BinaryNumber type, bool big_endian, double& value) {
  std::array<char, 8> raw{};
  const auto bytes = static_cast<std::size_t>(type.bytes);
  if (!data.read_bytes(raw.data(), bytes)) return false;
  value = value_of(raw.data(), type, big_endian);
  return true;
}

/// Reads a property of binary data, and skips lists; false if the file ends in it, or a list has a
/// negative length.
bool take(TextReader& data, const Property& property, bool big_endian, double& value) {
  if (property.length.bytes == 0) return take(data, property.type, big_endian, value);
  double length = 0;
  if (!take(data, property.length, big_endian, length) || length < 0) return false;
  return data.skip_bytes(static_cast<std::uint64_t>(length) *
                         static_cast<std::uint64_t>(property.type.bytes));
}

void read_binary(TextReader& data, bool big_endian, const Element& element, PointFile* file) {
  const std::array<std::size_t, 3> xyz =
      file != nullptr ? coordinates(data, element) : std::array<std::size_t, 3>{};
  const std::optional<std::size_t> time = time_property(element);
  if (element.properties.empty()) return;
  for (std::int64_t row = 0; row < element.count; ++row) {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    double seen = 0;
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      double value = 0;
      if (!take(data, element.properties[i], big_endian, value)) fail_short(data, element, row);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (xyz[axis] == i) point[static_cast<Eigen::Index>(axis)] = value;
      }
      if (time == i) seen = value;
    }
    if (file == nullptr) continue;
    add_point(*file, point, data.name());
    if (time) add_time(*file, seen, element.properties[*time].type);
  }
}

}  // namespace

PointFile read_ply(const std::string& path) {
  TextReader text(path, {TextFormat::Cut::kWords, ""});
  const PlyHeader header = read_ply_header(text);
  PointFile file;
  bool has_points = false;
  for (const Element& element : header.elements) {
    const bool points = !has_points && element.name == "vertex";
    has_points = has_points || points;
    PointFile* out = points ? &file : nullptr;
    if (header.encoding == Encoding::kText) {
      read_text(text, element, out);
    } else {
      read_binary(text, header.encoding == Encoding::kBigEndian, element, out);
    }
  }
  if (!has_points) text.fail("the header has no element 'vertex'");
  if (header.encoding != Encoding::kText) return file;
  TextRow row;
  if (text.next(row)) row.fail("the elements of the header have ended, but more follows");
  return file;
}

}  // namespace hybrid
