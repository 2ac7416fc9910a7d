// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <array>
#include <cstdint>
#include <cstring>
#include <utility>

#include "libhybrid/io/point_text.h"

namespace hybrid {
namespace {

enum class Encoding { kText, kLittleEndian, kBigEndian };

/// A scalar type of PLY: bytes, and 'i' signed, 'u' unsigned, 'f' floating.
struct Scalar {
  int bytes = 0;
  char kind = 0;
};

struct Property {
  std::string name;
  Scalar type;
  Scalar length;  // of a list; no bytes for a single value
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::kText;
  std::vector<Element> elements;
};

Scalar scalar(const PointText& text, std::string_view name) {
  static constexpr std::pair<std::string_view, Scalar> kTypes[] = {
      {"char", {1, 'i'}},  {"int8", {1, 'i'}},    {"uchar", {1, 'u'}},  {"uint8", {1, 'u'}},
      {"short", {2, 'i'}}, {"int16", {2, 'i'}},   {"ushort", {2, 'u'}}, {"uint16", {2, 'u'}},
      {"int", {4, 'i'}},   {"int32", {4, 'i'}},   {"uint", {4, 'u'}},   {"uint32", {4, 'u'}},
      {"float", {4, 'f'}}, {"float32", {4, 'f'}}, {"double", {8, 'f'}}, {"float64", {8, 'f'}}};
  for (const auto& [known, type] : kTypes) {
    if (name == known) return type;
  }
  text.fail("'" + std::string(name) + "' is not a type of PLY");
}

void read_property(const PointText& text, const std::vector<std::string_view>& words,
                   Header& header) {
  if (header.elements.empty()) text.fail("a property before the first element");
  const bool list = words.size() == 5 && words[1] == "list";
  if (!list && words.size() != 3) text.fail("expected 'property TYPE NAME'");
  Property property;
  property.name = std::string(words.back());
  property.type = scalar(text, words[words.size() - 2]);
  if (list) property.length = scalar(text, words[2]);
  header.elements.back().properties.push_back(property);
}

Header read_header(PointText& text) {
  std::vector<std::string_view> words;
  if (!text.next(words) || words.size() != 1 || words[0] != "ply") {
    text.fail("not a PLY file: it does not begin with 'ply'");
  }
  Header header;
  bool format = false;
  while (text.next(words)) {
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") {
      if (!format) text.fail("the header has no 'format' line");
      return header;
    }
    if (words[0] == "format" && words.size() == 3) {
      format = true;
      if (words[1] == "ascii") {
        header.encoding = Encoding::kText;
      } else if (words[1] == "binary_little_endian") {
        header.encoding = Encoding::kLittleEndian;
      } else if (words[1] == "binary_big_endian") {
        header.encoding = Encoding::kBigEndian;
      } else {
        text.fail("unknown format '" + std::string(words[1]) + "'");
      }
    } else if (words[0] == "element" && words.size() == 3) {
      header.elements.push_back({std::string(words[1]), text.count(words[2]), {}});
    } else if (words[0] == "property") {
      read_property(text, words, header);
    } else {
      text.fail("'" + std::string(words[0].substr(0, 40)) + "' is not part of a PLY header");
    }
  }
  text.fail("the file ends inside the header");
}

/// Which property of an element is x, y and z.
std::array<std::size_t, 3> coordinates(const PointText& text, const Element& element) {
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

[[noreturn]] void fail_short(const PointText& text, const Element& element, std::size_t read) {
  text.fail("the header says " + std::to_string(element.count) + " of element '" + element.name +
            "', the file ends after " + std::to_string(read));
}

void read_text(PointText& text, const Element& element, PointFile* file) {
  const std::array<std::size_t, 3> xyz =
      file != nullptr ? coordinates(text, element) : std::array<std::size_t, 3>{};
  std::vector<std::string_view> words;
  for (std::size_t row = 0; row < element.count;) {
    if (!text.next(words)) fail_short(text, element, row);
    if (words.empty()) continue;
    ++row;
    if (file == nullptr) continue;
    if (words.size() < element.properties.size()) {
      text.fail("a vertex has " + std::to_string(element.properties.size()) + " properties, got " +
                std::to_string(words.size()));
    }
    add_point(*file,
              {text.number(words[xyz[0]]), text.number(words[xyz[1]]), text.number(words[xyz[2]])});
  }
}

/// Reads values out of binary data.
class Bytes {
 public:
  Bytes(std::string_view data, bool big_endian) : data_(data), swap_(big_endian) {}

  bool has(std::size_t count) const { return data_.size() >= count; }
  void skip(std::size_t count) { data_.remove_prefix(count); }

  double take(Scalar type) {
    std::array<unsigned char, 8> raw{};
    for (int i = 0; i < type.bytes; ++i) {
      raw[swap_ ? type.bytes - 1 - i : i] = static_cast<unsigned char>(data_[i]);
    }
    data_.remove_prefix(type.bytes);
    if (type.kind == 'f') {
      if (type.bytes == 8) return as<double>(raw);
      return static_cast<double>(as<float>(raw));
    }
    std::uint64_t bits = 0;
    for (int i = type.bytes - 1; i >= 0; --i) bits = (bits << 8) | raw[i];
    const std::uint64_t sign = std::uint64_t(1) << (8 * type.bytes - 1);
    if (type.kind == 'u' || (bits & sign) == 0) return static_cast<double>(bits);
    return static_cast<double>(bits) - 2.0 * static_cast<double>(sign);
  }

 private:
  template <class T>
  static T as(const std::array<unsigned char, 8>& raw) {
    T value;
    std::memcpy(&value, raw.data(), sizeof(value));
    return value;
  }

  std::string_view data_;
  bool swap_;
};

void read_binary(const PointText& text, Bytes& bytes, const Element& element, PointFile* file) {
  const std::array<std::size_t, 3> xyz =
      file != nullptr ? coordinates(text, element) : std::array<std::size_t, 3>{};
  for (std::size_t row = 0; row < element.count; ++row) {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const Property& property = element.properties[i];
      if (!bytes.has(property.length.bytes)) fail_short(text, element, row);
      if (property.length.bytes > 0) {
        const double length = bytes.take(property.length);
        if (!(length >= 0.0) ||
            !bytes.has(static_cast<std::size_t>(length) * property.type.bytes)) {
          fail_short(text, element, row);
        }
        bytes.skip(static_cast<std::size_t>(length) * property.type.bytes);
        continue;
      }
      if (!bytes.has(property.type.bytes)) fail_short(text, element, row);
      const double value = bytes.take(property.type);
      for (int axis = 0; file != nullptr && axis < 3; ++axis) {
        if (xyz[axis] == i) point[axis] = value;
      }
    }
    if (file != nullptr) add_point(*file, point);
  }
}

}  // namespace

PointFile read_ply(PointText& text) {
  const Header header = read_header(text);
  PointFile file;
  Bytes bytes(text.rest(), header.encoding == Encoding::kBigEndian);
  for (const Element& element : header.elements) {
    PointFile* out = element.name == "vertex" ? &file : nullptr;
    if (header.encoding == Encoding::kText) {
      read_text(text, element, out);
    } else {
      read_binary(text, bytes, element, out);
    }
    if (out != nullptr) return file;
  }
  text.fail("the header has no element 'vertex'");
}

}  // namespace hybrid
