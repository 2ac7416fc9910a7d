// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "libhybrid/core/error.h"

namespace hybrid {

/// The cells of the rows of a query, each of the type that it is to have. All throw Error that
/// names table and column where it is not.
class MapCells {
 public:
  MapCells(SQLite::Database& database, std::string table, const std::string& query)
      : table_(std::move(table)), rows_(database, query) {}

  bool next() { return rows_.executeStep(); }
  /// Whether there is a value.
  bool is_null(int column) { return rows_.getColumn(column).isNull(); }

  /// A finite number.
  double real(int column) {
    const SQLite::Column cell = rows_.getColumn(column);
    if (!cell.isFloat() && !cell.isInteger()) throw wrong(column, "no number");
    const double value = cell.getDouble();
    if (!std::isfinite(value)) throw wrong(column, "not finite");
    return value;
  }
  /// A whole number from `least` to `most`.
  std::int64_t whole(int column, std::int64_t least = 0,
                     std::int64_t most = std::numeric_limits<int>::max()) {
    const SQLite::Column cell = rows_.getColumn(column);
    if (!cell.isInteger()) throw wrong(column, "no whole number");
    const std::int64_t value = cell.getInt64();
    if (value < least || value > most) {
      throw wrong(column, fmt::format("{}, not from {} to {}", value, least, most));
    }
    return value;
  }
  int count(int column) { return static_cast<int>(whole(column)); }
  std::string text(int column) {
    const SQLite::Column cell = rows_.getColumn(column);
    if (!cell.isText()) throw wrong(column, "no text");
    return cell.getString();
  }
  /// Bytes, a whole number of parts of a size.
  std::string bytes(int column, std::size_t part) {
    const SQLite::Column cell = rows_.getColumn(column);
    if (!cell.isBlob()) throw wrong(column, "no bytes");
    const void* data = cell.getBlob();  // first, since the size is that of the last form asked for
    const auto size = static_cast<std::size_t>(cell.getBytes());
    if (size % part != 0) throw wrong(column, fmt::format("cut off after {} bytes", size));
    return size == 0 ? std::string() : std::string(static_cast<const char*>(data), size);
  }

 private:
  Error wrong(int column, const std::string& what) {
    return Error(fmt::format("is no sound map: '{}' of a row of table '{}' is {}",
                             rows_.getColumn(column).getName(), table_, what));
  }

  std::string table_;
  SQLite::Statement rows_;
};

}  // namespace hybrid
