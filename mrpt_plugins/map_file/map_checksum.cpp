// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>

#include "mrpt_plugins/map_file/detail/map_database.h"
#include "mrpt_plugins/map_file/detail/map_schema.h"

namespace hybrid {
namespace {

/// Everything that is covered; columns and rows in the order of docs/map_format.md.
constexpr const char* kContent[] = {
    "SELECT * FROM map WHERE name <> 'checksum' ORDER BY name",
    "SELECT * FROM class ORDER BY number",
    "SELECT * FROM session ORDER BY id",
    "SELECT * FROM input ORDER BY session, number",
    "SELECT * FROM robot ORDER BY session, number",
    ("SELECT * FROM keyframe WHERE session IN (SELECT id FROM session WHERE complete = 1) "
     "ORDER BY session, number"),
    "SELECT * FROM landmark ORDER BY id",
    "SELECT * FROM landmark_class ORDER BY landmark, class",
    "SELECT * FROM prior ORDER BY landmark, number"};
/// What files of a version with local maps have besides.
constexpr const char* kScans[] = {"SELECT * FROM local_map ORDER BY session, number",
                                  "SELECT * FROM surface ORDER BY session, map, number"};
/// What those that say what landmarks stand for have besides.
constexpr const char* kSizes = "SELECT * FROM landmark_size ORDER BY landmark";
/// And those with clouds.
constexpr const char* kClouds = "SELECT * FROM local_cloud ORDER BY session, number";
/// And those that tell how well local maps are known beside each other.
constexpr const char* kParents = "SELECT * FROM place_parent ORDER BY session, number";

/// FNV-1a of 64 bits.
class Checksum {
 public:
  void add(const void* bytes, std::size_t count) {
    const auto* b = static_cast<const unsigned char*>(bytes);
    for (std::size_t i = 0; i < count; ++i) sum_ = (sum_ ^ b[i]) * 0x100000001b3ULL;
  }
  /// Eight bytes, the lowest first.
  void add(std::uint64_t number) {
    for (int i = 0; i < 64; i += 8) {
      const auto byte = static_cast<unsigned char>(number >> i);
      add(&byte, 1);
    }
  }
  std::string text() const { return fmt::format("{:016x}", sum_); }

 private:
  std::uint64_t sum_ = 0xcbf29ce484222325ULL;
};

/// The type of a value by SQLite's numbers, then what it is.
void add_value(const SQLite::Column& value, Checksum& sum) {
  sum.add(static_cast<std::uint64_t>(value.getType()));
  if (value.isInteger()) {
    sum.add(static_cast<std::uint64_t>(value.getInt64()));
  } else if (value.isFloat()) {
    const double real = value.getDouble();
    std::uint64_t bits = 0;
    std::memcpy(&bits, &real, sizeof bits);
    sum.add(bits);
  } else if (!value.isNull()) {
    const void* bytes =
        value.getBlob();  // first, since the size is that of the last form asked for
    const auto size = static_cast<std::size_t>(value.getBytes());
    sum.add(static_cast<std::uint64_t>(size));
    sum.add(bytes, size);
  }
}

void add_rows(SQLite::Database& database, const char* query, Checksum& sum) {
  SQLite::Statement rows(database, query);
  while (rows.executeStep()) {
    for (int i = 0; i < rows.getColumnCount(); ++i) add_value(rows.getColumn(i), sum);
  }
}

std::string checksum_of(SQLite::Database& database) {
  Checksum sum;
  for (const char* const query : kContent) add_rows(database, query, sum);
  if (pragma(database, "user_version") >= map_schema::kFirstWithScans) {
    for (const char* const query : kScans) add_rows(database, query, sum);
  }
  if (pragma(database, "user_version") >= map_schema::kFirstWithSizes) {
    add_rows(database, kSizes, sum);
  }
  if (pragma(database, "user_version") >= map_schema::kFirstWithClouds) {
    add_rows(database, kClouds, sum);
  }
  if (pragma(database, "user_version") >= map_schema::kFirstWithParents) {
    add_rows(database, kParents, sum);
  }
  return sum.text();
}

std::optional<std::string> noted(SQLite::Database& database) {
  SQLite::Statement row(database, "SELECT value FROM map WHERE name = 'checksum'");
  return row.executeStep() ? std::make_optional(row.getColumn(0).getString()) : std::nullopt;
}

}  // namespace

bool note_checksum(SQLite::Database& database) {
  const std::string sum = checksum_of(database);
  if (noted(database) == sum) return false;
  SQLite::Statement row(database, "INSERT OR REPLACE INTO map VALUES ('checksum', ?)");
  row.bind(1, sum);
  row.exec();
  return true;
}

void check_checksum(SQLite::Database& database) {
  if (pragma(database, "user_version") < map_schema::kFirstWithChecksum) return;
  if (noted(database) == checksum_of(database)) return;
  throw Error("is damaged: its checksum is not that of its content; take a copy from before");
}

}  // namespace hybrid
