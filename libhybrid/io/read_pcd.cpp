// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libhybrid/io/binary_number.h"
#include "libhybrid/io/escaped.h"
#include "libhybrid/io/point_formats.h"
#include "libhybrid/io/text_reader.h"

namespace hybrid {
namespace {

constexpr std::size_t kLongestLiteral = 32;  // bytes; a control byte below it begins a literal
constexpr std::size_t kLongLength = 7;       // of a copy; another byte is added to it

/// So many bytes; fewer where the file ends.
std::string bytes_in(TextReader& data, std::size_t count) {
  constexpr std::size_t kStep = std::size_t{1} << 20;
  std::string out;
  while (out.size() < count) {
    const std::size_t had = out.size();
    out.resize(std::min(count, had + kStep));
    if (!data.read_bytes(&out[had], out.size() - had)) data.fail("the compressed data ends early");
  }
  return out;
}

/// Takes the next byte; false at the end.
bool take(std::string_view& packed, std::size_t& byte) {
  if (packed.empty()) return false;
  byte = static_cast<unsigned char>(packed.front());
  packed.remove_prefix(1);
  return true;
}

/// Unpacks a block, a literal or a copy of what has been unpacked; false where there is none.
bool unpack_block(std::string_view& packed, std::string& out) {
  std::size_t control = 0;
  if (!take(packed, control)) return false;
  if (control < kLongestLiteral) {
    if (packed.size() < control + 1) return false;
    out += packed.substr(0, control + 1);
    packed.remove_prefix(control + 1);
    return true;
  }
  std::size_t length = control >> 5U, more = 0, low = 0;
  if (length == kLongLength && !take(packed, more)) return false;
  if (!take(packed, low)) return false;
  length += more + 2;
  const std::size_t back = ((control & 31U) << 8U) + low + 1;
  if (back > out.size()) return false;
  for (std::size_t i = 0; i < length; ++i) out += out[out.size() - back];
  return true;
}

/// The bytes that follow the lines read, as PCD compresses them: two numbers of 32 bits, the sizes
/// compressed and uncompressed, then blocks of LZF. Throws Error if the file ends early, or the
/// blocks do not give that size. Takes memory as the blocks come, whatever the sizes say.
std::string read_lzf(TextReader& data) {
  constexpr BinaryNumber kSize{4, 'u'};
  std::array<char, 8> head{};
  if (!data.read_bytes(head.data(), head.size())) data.fail("the compressed data is missing");
  const auto packed_size = static_cast<std::size_t>(value_of(head.data(), kSize, false));
  const auto size = static_cast<std::size_t>(value_of(head.data() + 4, kSize, false));
  const std::string packed = bytes_in(data, packed_size);
  std::string_view rest = packed;
  std::string out;
  while (out.size() <= size && !rest.empty()) {
    if (!unpack_block(rest, out)) data.fail("the compressed data is damaged");
  }
  if (out.size() != size) {
    data.fail("the compressed data is damaged: it does not have the size that it states");
  }
  return out;
}

constexpr std::int64_t kMostPoints = std::int64_t{1} << 31;
constexpr std::int64_t kMostValues = 1000;  // of a field

struct PcdHeader {
  enum class Data { kText, kBinary, kCompressed };
  std::vector<std::string> fields;
  std::vector<std::size_t> counts;  // values of each field; empty: one of each
  std::vector<int> sizes;           // bytes of a value of each field
  std::string types;                // a letter for each field
  std::int64_t points = 0;
  bool has_points = false;
  Data data = Data::kText;
};

PcdHeader::Data data_in(const TextRow& row) {
  row.expect(2, "DATA ascii, DATA binary or DATA binary_compressed");
  if (row[1] == "ascii") return PcdHeader::Data::kText;
  if (row[1] == "binary") return PcdHeader::Data::kBinary;
  if (row[1] == "binary_compressed") return PcdHeader::Data::kCompressed;
  row.fail(1, in_quotes(row[1]) + " is none of ascii, binary and binary_compressed");
}

/// Takes a line of the header that says something of each field; false for any other.
bool take_fields(const TextRow& row, PcdHeader& header) {
  const std::string_view what = row[0];
  if (what != "FIELDS" && what != "COUNT" && what != "SIZE" && what != "TYPE") return false;
  for (std::size_t i = 1; i < row.size(); ++i) {
    if (what == "FIELDS") {
      header.fields.emplace_back(row[i]);
    } else if (what == "COUNT") {
      header.counts.push_back(static_cast<std::size_t>(row.id(i, kMostValues)));
    } else if (what == "SIZE") {
      header.sizes.push_back(static_cast<int>(row.id(i, 8)));
    } else {
      header.types += row[i].front();
    }
  }
  return true;
}

/// Reads the header up to its DATA line.
PcdHeader read_pcd_header(TextReader& text) {
  PcdHeader header;
  std::int64_t width = 0, height = 1;
  TextRow row;
  while (text.next(row)) {
    const std::string_view what = row[0];
    if (what != "DATA") row.expect(2, row.size(), std::string(what.substr(0, 40)) + " and a value");
    if (take_fields(row, header)) continue;
    if (what == "WIDTH") {
      width = row.id(1, kMostPoints);
    } else if (what == "HEIGHT") {
      height = row.id(1, kMostPoints);
    } else if (what == "POINTS") {
      header.points = row.id(1, kMostPoints);
      header.has_points = true;
    } else if (what == "DATA") {
      header.data = data_in(row);
      if (!header.has_points) header.points = width * height;
      return header;
    } else if (what != "VERSION" && what != "VIEWPOINT") {
      row.fail(in_quotes(what) + " is not part of a PCD header");
    }
  }
  text.fail("not a PCD file: it has no DATA line");
}

/// Where a field is among the values of a point, and in its bytes.
struct PcdField {
  std::size_t column = 0;
  std::size_t offset = 0;  // of data that is not text
  BinaryNumber type;
};

struct PcdLayout {
  std::array<PcdField, 3> xyz;
  std::optional<PcdField> time;
  std::size_t values = 0, bytes = 0;  // of a point
};

BinaryNumber scalar_of(const TextReader& text, const PcdHeader& header, std::size_t field) {
  const int bytes = header.sizes[field];
  const char type = header.types[field];
  const bool is_whole = type == 'I' || type == 'U';
  const bool is_known = (type == 'F' && (bytes == 4 || bytes == 8)) ||
                        (is_whole && (bytes == 1 || bytes == 2 || bytes == 4));
  if (!is_known) {
    text.fail("field " + in_quotes(header.fields[field]) + " has " + std::to_string(bytes) +
              " bytes of type " + in_quotes(std::string(1, type)) +
              "; x, y and z are F of 4 or 8 bytes, or I or U of 1, 2 or 4");
  }
  return {bytes, type == 'F' ? 'f' : type == 'I' ? 'i' : 'u'};
}

/// Seconds where the header does not say; nothing for a type that no time has.
std::optional<BinaryNumber> time_type(const PcdHeader& header, std::size_t field) {
  const std::size_t count = header.fields.size();
  if (header.sizes.size() != count || header.types.size() != count) return BinaryNumber{8, 'f'};
  const int bytes = header.sizes[field];
  const char type = header.types[field];
  if (type == 'F' && (bytes == 4 || bytes == 8)) return BinaryNumber{bytes, 'f'};
  const bool is_whole = (type == 'I' || type == 'U') && (bytes == 4 || bytes == 8);
  if (!is_whole) return std::nullopt;
  return BinaryNumber{bytes, type == 'I' ? 'i' : 'u'};
}

PcdLayout layout_of(const TextReader& text, const PcdHeader& header) {
  const std::size_t count = header.fields.size();
  if (!header.counts.empty() && header.counts.size() != count) {
    text.fail("COUNT and FIELDS differ in length");
  }
  const bool is_text = header.data == PcdHeader::Data::kText;
  if (!is_text && (header.sizes.size() != count || header.types.size() != count)) {
    text.fail("SIZE or TYPE and FIELDS differ in length");
  }
  PcdLayout layout;
  std::array<bool, 3> found{};
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t values = header.counts.empty() ? 1 : header.counts[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (values != 1 || header.fields[i] != std::string(1, "xyz"[axis])) continue;
      layout.xyz[axis] = {layout.values, layout.bytes, {}};
      if (!is_text) layout.xyz[axis].type = scalar_of(text, header, i);
      found[axis] = true;
    }
    if (values == 1 && !layout.time && is_time_field(header.fields[i])) {
      const std::optional<BinaryNumber> type = time_type(header, i);
      if (type) layout.time = PcdField{layout.values, layout.bytes, *type};
    }
    layout.values += values;
    if (!is_text) layout.bytes += values * static_cast<std::size_t>(header.sizes[i]);
  }
  if (!found[0] || !found[1] || !found[2]) text.fail("FIELDS has no x, y and z");
  return layout;
}

[[noreturn]] void fail_short(const TextReader& text, const PcdHeader& header, std::int64_t read) {
  text.fail("the header says " + std::to_string(header.points) + " points, the file ends after " +
            std::to_string(read));
}

void read_text(TextReader& text, const PcdHeader& header, const PcdLayout& layout,
               PointFile& file) {
  TextRow row;
  for (std::int64_t read = 0; read < header.points; ++read) {
    if (!text.next(row)) fail_short(text, header, read);
    row.expect(layout.values, std::to_string(layout.values) + " values of a point");
    add_point(file, row, {layout.xyz[0].column, layout.xyz[1].column, layout.xyz[2].column});
    if (layout.time) add_time(file, row, layout.time->column, layout.time->type);
  }
  if (text.next(row)) {
    row.fail("the header says " + std::to_string(header.points) + " points, but more follow");
  }
}

void read_binary(TextReader& data, const PcdHeader& header, const PcdLayout& layout,
                 PointFile& file) {
  std::string raw(layout.bytes, '\0');
  for (std::int64_t read = 0; read < header.points; ++read) {
    if (!data.read_bytes(raw.data(), raw.size())) fail_short(data, header, read);
    Eigen::Vector3d point;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      point[static_cast<Eigen::Index>(axis)] =
          value_of(&raw[layout.xyz[axis].offset], layout.xyz[axis].type, false);
    }
    add_point(file, point, data.name());
    if (layout.time) {
      const PcdField& time = *layout.time;
      add_time(file, value_of(&raw[time.offset], time.type, false), time.type);
    }
  }
}

/// The values of one field follow those of the other, all compressed together by LZF.
void read_compressed(TextReader& data, const PcdHeader& header, const PcdLayout& layout,
                     PointFile& file) {
  const std::string raw = read_lzf(data);
  const auto points = static_cast<std::size_t>(header.points);
  if (raw.size() != points * layout.bytes) {
    data.fail("the header says " + std::to_string(points) + " points of " +
              std::to_string(layout.bytes) + " bytes, and the data has " +
              std::to_string(raw.size()) + " bytes");
  }
  for (std::size_t i = 0; i < points; ++i) {
    const auto value = [&](const PcdField& field) {
      const std::size_t at = points * field.offset + i * static_cast<std::size_t>(field.type.bytes);
      return value_of(&raw[at], field.type, false);
    };
    const auto& [x, y, z] = layout.xyz;
    add_point(file, {value(x), value(y), value(z)}, data.name());
    if (layout.time) add_time(file, value(*layout.time), layout.time->type);
  }
}

}  // namespace

PointFile read_pcd(const std::string& path) {
  TextReader text(path, {TextFormat::Cut::kWords, "#"});
  const PcdHeader header = read_pcd_header(text);
  const PcdLayout layout = layout_of(text, header);
  PointFile file;
  switch (header.data) {
    case PcdHeader::Data::kText:
      read_text(text, header, layout, file);
      break;
    case PcdHeader::Data::kBinary:
      read_binary(text, header, layout, file);
      break;
    case PcdHeader::Data::kCompressed:
      read_compressed(text, header, layout, file);
      break;
  }
  return file;
}

}  // namespace hybrid
