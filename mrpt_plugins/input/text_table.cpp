// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/text_table.h"

#include <fmt/format.h>

#include <cmath>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/ini_text.h"

namespace hybrid {
namespace {

std::vector<std::string> split_at_commas(const std::string& line) {
  std::vector<std::string> words;
  std::size_t begin = 0;
  if (ini::trimmed(line).empty()) return words;
  while (true) {
    const std::size_t comma = line.find(',', begin);
    words.push_back(ini::trimmed(line.substr(begin, comma - begin)));
    if (comma == std::string::npos) return words;
    begin = comma + 1;
  }
}

}  // namespace

std::string TextRow::where() const {
  return fmt::format("{}:{}", *path, line);
}

void TextRow::fail(const std::string& what) const {
  throw Error(fmt::format("{}: {}", where(), what));
}

void TextRow::expect_columns(std::size_t min, std::size_t max, const char* form) const {
  if (words.size() >= min && words.size() <= max) return;
  fail(fmt::format("{} columns; expected: {}", words.size(), form));
}

double TextRow::number(std::size_t column) const {
  double value = 0;
  if (ini::parse(words[column], value)) return value;
  fail(fmt::format("column {}: '{}' is not a finite number", column + 1, words[column]));
}

std::vector<double> TextRow::numbers(std::size_t from) const {
  std::vector<double> out;
  for (std::size_t column = from; column < words.size(); ++column) out.push_back(number(column));
  return out;
}

std::int64_t TextRow::id(std::size_t column) const {
  const double value = number(column);
  if (std::floor(value) == value && value >= 0 && value < 1e15) {
    return static_cast<std::int64_t>(value);
  }
  fail(fmt::format("column {}: '{}' is not an id", column + 1, words[column]));
}

TextTable::TextTable(const std::string& path, Columns columns)
    : path_(path), columns_(columns), file_(path) {
  if (!file_) throw Error(fmt::format("{}: no such file, or not readable", path));
}

std::optional<TextRow> TextTable::next() {
  for (std::string text; std::getline(file_, text);) {
    ++line_;
    const std::size_t mark = text.find_first_of("%#");
    if (mark != std::string::npos && on_comment) on_comment(text.substr(mark + 1));
    const std::string content = text.substr(0, mark);
    TextRow row{&path_, line_,
                columns_ == Columns::kCommas ? split_at_commas(content) : ini::words(content)};
    if (row.words.empty()) continue;
    ++rows_;
    return row;
  }
  if (rows_ == 0) throw Error(fmt::format("{}: holds no row", path_));
  return std::nullopt;
}

}  // namespace hybrid
