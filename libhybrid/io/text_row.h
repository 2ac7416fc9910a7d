// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Largest coordinate [unit of the file] that is read: doubles beyond it are 0.1 and more apart,
/// and its square is far from the end of their range.
inline constexpr double kLargestCoordinate = 1e15;
/// Largest time [s] that is read, of the year 5138. A larger one is in another unit.
inline constexpr double kLargestTime = 1e11;

/// A line of a text file, cut into words, and its place for messages. Words count from 0, lines and
/// columns of characters from 1. All errors are Error "file:line:column: what".
class TextRow {
 public:
  std::size_t size() const { return count_; }
  std::string_view operator[](std::size_t i) const {
    return std::string_view(text_).substr(words_[i].begin, words_[i].end - words_[i].begin);
  }
  std::size_t line() const { return line_; }

  /// Throws Error unless there are `least` to `most` words; `form` describes them in the message.
  void expect(std::size_t least, std::size_t most, std::string_view form) const;
  /// The same for one number of words.
  void expect(std::size_t count, std::string_view form) const { expect(count, count, form); }

  /// Throws Error unless there are `columns` words. If `columns` is 0, as in the first row, there
  /// must be at least `least`, and it is set to their number.
  void expect_same(std::size_t& columns, std::size_t least, std::string_view form) const;

  /// A finite number.
  double number(std::size_t i) const;
  /// Words i to end - 1, all finite numbers.
  std::vector<double> numbers(std::size_t i, std::size_t end) const;
  /// A finite number of at most kLargestCoordinate [unit of the file].
  double coordinate(std::size_t i) const;
  /// A time of at most kLargestTime [s], a number or a date of ISO 8601.
  double time(std::size_t i) const;
  /// A whole number from 0 to `most`, `5` or `5.0`.
  std::int64_t id(std::size_t i,
                  std::int64_t most = std::numeric_limits<std::int32_t>::max()) const;

  /// Throws Error with the place of word i, or of the end of the line if i is size().
  [[noreturn]] void fail(std::size_t i, const std::string& what) const;
  /// The same with the place of the first word.
  [[noreturn]] void fail(const std::string& what) const { fail(0, what); }

 private:
  friend class TextReader;
  struct Span {
    std::uint32_t begin, end;
  };

  void cut_words();
  void cut_cells();
  void add(std::size_t begin, std::size_t end) {
    words_[count_++] = {static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end)};
  }
  std::string hint(std::string_view word) const;

  std::shared_ptr<const std::string> file_;
  std::size_t line_ = 0;
  std::string text_;
  std::vector<Span> words_;  // room for the longest row so far; the first count_ are in use
  std::size_t count_ = 0;
  char separator_ = ' ';
};

/// "file:line:column: what", for the byte `at` of a line; columns count characters.
std::string at_place(const std::string& file, std::size_t line, std::string_view text,
                     std::size_t at, const std::string& what);

}  // namespace hybrid
