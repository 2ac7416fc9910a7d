// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libhybrid/io/escaped.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/import/detail/log_time.h"
#include "mrpt_plugins/import/detail/stated_noise.h"
#include "mrpt_plugins/import/log_writer.h"

namespace hybrid {

/// No name of a column does.
inline bool starts_like_a_number(std::string_view word) {
  return !word.empty() && (std::isdigit(static_cast<unsigned char>(word[0])) != 0 ||
                           std::string_view("+-.").find(word[0]) != std::string_view::npos);
}

inline constexpr std::string_view kProbabilityPrefix = "p_";  // and the name of a class

inline bool is_probability(std::string_view name) {
  return name.size() > kProbabilityPrefix.size() &&
         name.substr(0, kProbabilityPrefix.size()) == kProbabilityPrefix;
}

/// The name of a column as others write it, "Time [s]" or "X (m)": in small letters and without the
/// unit. Classes of columns p_NAME keep theirs.
struct ColumnHeading {
  explicit ColumnHeading(std::string_view text) {
    const std::size_t bracket = text.find_first_of("[(");
    if (bracket != std::string_view::npos && bracket > 0) {
      unit = in_small_letters(text.substr(bracket + 1, text.find_first_of("])") - bracket - 1));
      text = text.substr(0, text.find_last_not_of(' ', bracket - 1) + 1);
    }
    name = is_probability(text) ? std::string(text) : in_small_letters(text);
    if (name.size() > 4 && name.substr(name.size() - 4) == "_deg") unit = "deg";
  }
  static std::string in_small_letters(std::string_view text) {
    std::string small(text);
    for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return small;
  }
  /// Whether the unit is one that columns have, of that name.
  bool is_usual(const std::string& column) const {
    if (unit.empty()) return true;
    if (column == "latitude" || column == "longitude") return unit == "deg";
    return unit == "s" || unit == "m" || unit == "rad";
  }

  std::string name, unit;
};

/// Other names of columns, and those that they are read as.
using ColumnAliases = std::map<std::string, std::string>;

/// A table with commas whose first row names its columns; `known` with p_NAME has any such. Columns
/// that number the rows are left aside. A time may be in two columns, sec and nsec.
class NamedTable {
 public:
  NamedTable(const std::string& path, const std::vector<std::string>& known,
             const ColumnAliases& aliases = {})
      : table_(path) {
    const bool is_timed = std::find(known.begin(), known.end(), "time") != known.end();
    const bool has_probabilities = std::find(known.begin(), known.end(), "p_NAME") != known.end();
    const auto header = table_.next();
    for (std::size_t i = 0; i < header->size(); ++i) {
      const ColumnHeading heading((*header)[i]);
      std::string name = heading.name;
      if (is_row_number(name)) {
        ignored_.push_back(name);
        continue;
      }
      if (const auto alias = aliases.find(name); alias != aliases.end()) name = alias->second;
      if (!heading.is_usual(name)) {
        header->fail(i, fmt::format("column in {}: times are in seconds, lengths in metres, angles "
                                    "in radians, places on Earth in degrees",
                                    heading.unit));
      }
      if (is_timed && take_time_part(name, i)) continue;
      if (starts_like_a_number(name)) {
        header->fail(i, fmt::format("{} is no name: the first row names the columns; known are: {}",
                                    in_quotes(name), fmt::join(known, " ")));
      }
      if (std::find(known.begin(), known.end(), name) == known.end() &&
          !(has_probabilities && is_probability(name))) {
        header->fail(i, unknown_column(name, known, aliases));
      }
      if (!columns_.emplace(name, i).second) header->fail(i, fmt::format("two columns '{}'", name));
    }
    header_ = *header;
  }

  bool has(const std::string& name) const { return columns_.count(name) != 0; }
  /// Columns that number the rows.
  const std::vector<std::string>& ignored() const { return ignored_; }
  const std::string& path() const { return table_.name(); }
  /// Classes that have a column of probabilities, sorted.
  std::vector<std::string> probable_classes() const {
    std::vector<std::string> names;
    for (const auto& column : columns_) {
      if (is_probability(column.first))
        names.push_back(column.first.substr(kProbabilityPrefix.size()));
    }
    return names;
  }

  /// Throws Error that names the file unless all columns are there.
  void require(const std::vector<std::string>& names) const {
    for (const std::string& name : names) {
      if (!has(name)) header_.fail(fmt::format("no column '{}'", name));
    }
  }

  /// Throws Error about the first row.
  [[noreturn]] void refuse(const std::string& what) const { header_.fail(what); }

  bool next() {
    row_ = table_.next();
    if (!row_) return false;
    row_->expect(header_.size(), "one for each name of the first row");
    ++rows_;
    for (const auto& [name, i] : columns_) {
      if ((*row_)[i].empty()) ++blank_[name];
    }
    return true;
  }

  /// Share of the file that has been read.
  double share() const { return table_.share(); }

  std::string word(const std::string& name) const {
    return std::string((*row_)[columns_.at(name)]);
  }
  /// Of column time, or of whole seconds and nanoseconds, as ROS has them; as a log has it.
  double time() const {
    const double seconds = row_->time(columns_.at("time"));
    if (!nanoseconds_) return log_time(seconds);
    constexpr std::int64_t kSecond = 1'000'000'000;  // ns
    return log_time(seconds + static_cast<double>(row_->id(*nanoseconds_, kSecond - 1)) /
                                  static_cast<double>(kSecond));
  }
  double number(const std::string& name) const { return row_->coordinate(columns_.at(name)); }
  /// An angle [rad], which is not in degrees.
  double angle(const std::string& name) const {
    const double angle = number(name);
    if (std::abs(angle) <= 2 * M_PI) return angle;
    fail(name, fmt::format("{} {} is beyond 2 pi: angles are in radians", name, angle));
  }
  /// A standard deviation; 0 where the column is absent or the field empty or 0.
  double sigma(const std::string& name) const {
    if (!has(name) || word(name).empty() || number(name) == 0) return 0;
    return stated_sigma(*row_, columns_.at(name));
  }
  /// The row, and the place of a column in it.
  const TextRow& row() const { return *row_; }
  std::size_t column(const std::string& name) const { return columns_.at(name); }
  /// Tells the log how many fields were blank, by column.
  void note_blanks(LogWriter& log) const {
    for (const auto& [name, count] : blank_) {
      log.note(fmt::format("{}: {} of {} fields of column {} are blank", table_.name(), count,
                           rows_, name));
    }
  }
  [[noreturn]] void fail(const std::string& name, const std::string& what) const {
    row_->fail(columns_.at(name), what);
  }
  /// An id; nothing where the column is absent or the field empty or -1.
  std::optional<std::int64_t> id(const std::string& name) const {
    if (!has(name) || word(name).empty() || word(name) == "-1") return std::nullopt;
    return row_->id(columns_.at(name));
  }

 private:
  /// Whether a column is a part of the time.
  bool take_time_part(const std::string& name, std::size_t i) {
    if (name == "sec" || name == "secs") return columns_.emplace("time", i).second;
    if (name != "nsec" && name != "nsecs" && name != "nanosec") return false;
    nanoseconds_ = i;
    return true;
  }

  static bool is_row_number(const std::string& name) {
    return name.empty() || name == "num" || name == "index" || name == "row" || name == "seq";
  }

  static std::string unknown_column(const std::string& name, std::vector<std::string> known,
                                    const ColumnAliases& aliases) {
    const std::string list = fmt::format("nown are: {}", fmt::join(known, " "));
    for (const auto& [alias, column] : aliases) {
      if (std::find(known.begin(), known.end(), column) != known.end()) known.push_back(alias);
    }
    const std::string nearest = nearest_name(name, known);
    return fmt::format("unknown column {}; {}{}", in_quotes(name),
                       nearest.empty() ? "k" : fmt::format("did you mean '{}'? K", nearest), list);
  }

  TextReader table_;
  std::vector<std::string> ignored_;
  std::size_t rows_ = 0;
  std::map<std::string, std::size_t> blank_;  // fields by column
  TextRow header_;
  std::optional<TextRow> row_;
  std::map<std::string, std::size_t> columns_;
  std::optional<std::size_t> nanoseconds_;  // column of what is added to seconds
};

}  // namespace hybrid
