// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/text_row.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <optional>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "libhybrid/io/parse_number.h"

namespace hybrid {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

/// Whether a byte is a blank, by its value; the NUL that ends the text counts as one.
constexpr std::array<bool, 256> kIsBlank = [] {
  std::array<bool, 256> table{};
  table[0] = true;
  for (const char c : kBlanks) table[static_cast<unsigned char>(c)] = true;
  return table;
}();

bool is_blank(char c) {
  return kIsBlank[static_cast<unsigned char>(c)];
}

constexpr const char* kPoint = "decimals are written with a point";

/// Whether a word is a number that doubles cannot hold; one that underflows is malformed data, too.
bool is_out_of_range(std::string_view word) {
  double value = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data() + (word[0] == '+'), end, value);
  return error == std::errc::result_out_of_range && stop == end;
}

/// Whether a word is a number if its comma is replaced by a point.
bool has_decimal_comma(std::string_view word) {
  std::string changed(word);
  const std::size_t comma = changed.find(',');
  if (comma == std::string::npos) return false;
  changed[comma] = '.';
  double value = 0;
  return parse_number(changed, value);
}

/// Two or four digits of a word, as a number of at most `most`; nothing if they are others.
std::optional<int> digits_at(std::string_view word, std::size_t at, std::size_t count, int most) {
  const std::string_view digits = word.substr(at, count);
  int value = 0;
  if (digits.empty() || digits[0] < '0' || digits[0] > '9') return std::nullopt;
  if (!parse_number(digits, value) || value > most) return std::nullopt;
  return value;
}

/// The offset to UTC [min] that ends a time of ISO 8601, 0 for none; nothing if it is another word.
std::optional<int> offset_of(std::string_view zone) {
  if (zone.empty() || zone == "Z") return 0;
  if (zone.size() != 6 || zone[3] != ':') return std::nullopt;
  const auto hours = digits_at(zone, 1, 2, 23), minutes = digits_at(zone, 4, 2, 59);
  if (!hours || !minutes) return std::nullopt;
  return (zone[0] == '-' ? -1 : 1) * (60 * *hours + *minutes);
}

/// Seconds since 1970 of a time of ISO 8601, 2024-05-01T12:00:00.25, in UTC unless it says other;
/// nothing if the word is another.
std::optional<double> iso_time(std::string_view word) {
  constexpr std::size_t kSecond = 17;
  if (word.size() < kSecond + 2 || word[4] != '-' || word[7] != '-' || word[13] != ':' ||
      word[16] != ':' || (word[10] != 'T' && word[10] != ' ')) {
    return std::nullopt;
  }
  const auto year = digits_at(word, 0, 4, 9999), month = digits_at(word, 5, 2, 12);
  const auto day = digits_at(word, 8, 2, 31);
  const auto hour = digits_at(word, 11, 2, 23), minute = digits_at(word, 14, 2, 59);
  const std::size_t end = std::min(word.find_first_of("Z+-", kSecond), word.size());
  const auto offset = offset_of(word.substr(end));
  double second = 0;
  if (!year || !month || !day || !hour || !minute || !offset || *month == 0 || *day == 0 ||
      !digits_at(word, kSecond, 2, 59) ||
      !parse_number(word.substr(kSecond, end - kSecond), second) || second >= 60) {
    return std::nullopt;
  }
  std::tm date{};
  date.tm_year = *year - 1900;
  date.tm_mon = *month - 1;
  date.tm_mday = *day;
  const std::time_t midnight = timegm(&date);
  if (date.tm_mday != *day) return std::nullopt;  // the month has fewer days
  return static_cast<double>(midnight + 60 * (60 * *hour + *minute - *offset)) + second;
}

/// The unit in which a number is a time between 2001 and 2128, as a question; "" if there is none.
const char* unit_asked(double value) {
  constexpr double kFirst = 1e9, kLast = 5e9;  // s since 1970
  const auto is_time = [&](double unit) { return value >= kFirst * unit && value <= kLast * unit; };
  return is_time(1e3)   ? "; are these milliseconds?"
         : is_time(1e6) ? "; are these microseconds?"
         : is_time(1e9) ? "; are these nanoseconds?"
                        : "";
}

constexpr char kQuote = '"';

bool is_quoted(std::string_view cell) {
  return cell.size() >= 2 && cell.front() == kQuote && cell.back() == kQuote;
}

/// The place behind the quotes that begin at `at`, where "" is a quote within them; npos where none
/// begin there, or they do not end.
std::size_t behind_quotes(std::string_view text, std::size_t at) {
  if (at >= text.size() || text[at] != kQuote) return std::string_view::npos;
  std::size_t end = text.find(kQuote, at + 1);
  while (end != std::string_view::npos && text.substr(end + 1, 1) == "\"") {
    end = text.find(kQuote, end + 2);
  }
  return end == std::string_view::npos ? end : end + 1;
}

}  // namespace

void TextRow::cut_words() {
  separator_ = ' ';
  count_ = 0;
  const std::size_t most = text_.size() / 2 + 1;
  if (words_.size() < most) words_.resize(most);
  const char* const first = text_.data();
  const char* const last = first + text_.size();
  for (const char* c = first; c != last;) {
    if (is_blank(*c)) {
      ++c;
      continue;
    }
    const char* const begin = c;
    while (!is_blank(*c)) ++c;
    add(begin - first, c - first);
  }
}

void TextRow::cut_cells() {
  const std::string_view text = text_;
  separator_ = text.find(';') != std::string_view::npos   ? ';'
               : text.find(',') != std::string_view::npos ? ','
                                                          : ' ';
  const auto strip = [&](Span& cell) {
    if (!is_quoted(text.substr(cell.begin, cell.end - cell.begin))) return;
    ++cell.begin;
    --cell.end;
  };
  if (separator_ == ' ') {
    cut_words();
    std::for_each(words_.begin(), words_.begin() + std::ptrdiff_t(count_), strip);
    return;
  }
  count_ = 0;
  if (words_.size() < text.size() + 1) words_.resize(text.size() + 1);
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t behind = behind_quotes(text, text.find_first_not_of(kBlanks, begin));
    const std::size_t search = behind == std::string_view::npos ? begin : behind;
    const std::size_t end = std::min(text.find(separator_, search), text.size());
    const std::size_t from = std::min(text.find_first_not_of(kBlanks, begin), end);
    std::size_t to = end;
    while (to > from && is_blank(text[to - 1])) --to;
    add(from, to);
    strip(words_[count_ - 1]);
    begin = end + 1;
  }
}

void TextRow::fail(std::size_t i, const std::string& what) const {
  const std::size_t at = i < size() ? words_[i].begin : text_.size();
  throw Error(at_place(*file_, line_, text_, at, what));
}

/// A hint for messages from a word that is no number on how the file was written, or "".
std::string TextRow::hint(std::string_view word) const {
  if (has_decimal_comma(word)) return std::string("; ") + kPoint;
  const bool blank = word.find_first_of(" \t") != std::string_view::npos;
  if (separator_ == ',' && blank) {
    return std::string("; columns are separated by commas here, and ") + kPoint;
  }
  if (word.find(';') != std::string_view::npos) return "; columns are separated by blanks";
  return "";
}

void TextRow::expect(std::size_t least, std::size_t most, std::string_view form) const {
  if (size() >= least && size() <= most) return;
  std::string what = std::to_string(size()) + (size() == 1 ? " column" : " columns");
  what += "; expected: " + std::string(form);
  for (std::size_t i = 0; i < size(); ++i) {
    const std::string told = hint((*this)[i]);
    if (told.empty()) continue;
    what += told;
    break;
  }
  fail(std::min(most, size()), what);
}

void TextRow::expect_same(std::size_t& columns, std::size_t least, std::string_view form) const {
  if (columns == 0) {
    expect(least, size(), form);
    columns = size();
  }
  if (size() == columns) return;
  expect(columns, std::string(form) + " (" + std::to_string(columns) + " as in the first row)");
}

double TextRow::number(std::size_t i) const {
  const std::string_view word = (*this)[i];
  double value = 0;
  const bool is_number = parse_number(word, value);
  if (is_number && std::isfinite(value)) return value;
  if (word.empty()) fail(i, "an empty column; expected a number");
  if (is_number || is_out_of_range(word)) fail(i, in_quotes(word) + " is not a finite number");
  fail(i, in_quotes(word) + " is not a number" + hint(word));
}

std::vector<double> TextRow::numbers(std::size_t i, std::size_t end) const {
  std::vector<double> out;
  for (; i < end; ++i) out.push_back(number(i));
  return out;
}

double TextRow::coordinate(std::size_t i) const {
  const double value = number(i);
  if (std::abs(value) <= kLargestCoordinate) return value;
  fail(i, in_quotes((*this)[i]) + " is beyond 1e15, the largest coordinate that is read");
}

double TextRow::time(std::size_t i) const {
  const std::string_view word = (*this)[i];
  if (const auto time = iso_time(word)) return *time;
  if (word.find(':') != std::string_view::npos) {
    fail(i, in_quotes(word) + " is not a time in seconds, or as 2024-05-01T12:00:00.25");
  }
  const double value = number(i);
  if (std::abs(value) <= kLargestTime) return value;
  fail(i, in_quotes((*this)[i]) + " is not a time in seconds: it is beyond 1e11" +
              unit_asked(std::abs(value)));
}

std::int64_t TextRow::id(std::size_t i, std::int64_t most) const {
  std::uint64_t whole = 0;
  if (!parse_number((*this)[i], whole)) {
    const double value = number(i);
    if (value != std::floor(value) || value < 0) {
      fail(i, in_quotes((*this)[i]) + " is not a whole number of at least 0");
    }
    constexpr double kExact = 9007199254740992.0;  // doubles below are exact
    whole = value < kExact ? static_cast<std::uint64_t>(value) : std::uint64_t(-1);
  }
  if (whole <= static_cast<std::uint64_t>(most)) return static_cast<std::int64_t>(whole);
  fail(i, in_quotes((*this)[i]) + " is larger than " + std::to_string(most));
}

std::string at_place(const std::string& file, std::size_t line, std::string_view text,
                     std::size_t at, const std::string& what) {
  const auto begins = [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; };
  const auto column = std::count_if(text.begin(), text.begin() + std::ptrdiff_t(at), begins) + 1;
  return file + ":" + std::to_string(line) + ":" + std::to_string(column) + ": " + what;
}

}  // namespace hybrid
