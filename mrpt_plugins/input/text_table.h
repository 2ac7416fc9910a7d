// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace hybrid {

/// A row of a table and its place for messages.
struct TextRow {
  const std::string* path = nullptr;
  std::size_t line = 0;  ///< From 1.
  std::vector<std::string> words;

  /// "file:line".
  std::string where() const;
  /// Throws Error with the place and these words.
  [[noreturn]] void fail(const std::string& what) const;
  /// Throws Error unless there are min to max columns; `form` says what they should be.
  void expect_columns(std::size_t min, std::size_t max, const char* form) const;
  /// A finite number, or Error that names the column. Columns count from 0.
  double number(std::size_t column) const;
  /// The numbers from a column on, all finite.
  std::vector<double> numbers(std::size_t from = 0) const;
  /// A whole number of at least 0 (`5` or `5.0`), or Error.
  std::int64_t id(std::size_t column) const;
};

/// Streams the rows of a text file: columns between white space (and commas, where asked), empty
/// lines skipped, comments from `%` or `#` to the end of the line.
class TextTable {
 public:
  enum class Columns { kSpaces, kCommas };

  /// Throws Error if the file is missing or not readable.
  explicit TextTable(const std::string& path, Columns columns = Columns::kSpaces);

  /// Called with the text of every comment.
  std::function<void(const std::string&)> on_comment;

  /// The next row, or nothing at the end; throws Error if the file ends without any row.
  std::optional<TextRow> next();

 private:
  std::string path_;
  Columns columns_;
  std::ifstream file_;
  std::size_t line_ = 0;
  std::size_t rows_ = 0;
};

}  // namespace hybrid
