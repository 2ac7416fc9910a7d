// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <list>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hybrid {

class IniSection;

/// Interval a number must lie in; the bounds themselves belong to it unless `open`.
struct IniRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool open = false;
};
inline constexpr IniRange kAnyNumber{};
inline constexpr IniRange kNonNegative{0.0};
inline constexpr IniRange kPositive{0.0, std::numeric_limits<double>::infinity(), true};
inline constexpr IniRange kProbability{0.0, 1.0};

/// A strict INI file. Syntax and `@define`, `${NAME}`, `$env{}`, `$eval{}` are those of
/// mrpt::config::CConfigFile (names ignore case; a comment is a line that starts with `#`, `;` or
/// `//`, or the rest of a line from one of these after a space). What MRPT lets pass is an Error
/// that names file, line, section and key: unknown or repeated keys, wrong types, NaN, numbers out
/// of range, unclosed sections, a missing file.
///
/// Code that reads a key declares it: IniSection::get() takes type, default, range and meaning.
/// Once everything has been read, reject_unknown() throws if the file holds anything not declared,
/// and documentation() lists all that was. Not copyable: sections point to their file.
class IniFile {
 public:
  /// An empty file that documents: required keys do not throw, they give a zero value.
  IniFile() = default;
  IniFile(const IniFile&) = delete;
  IniFile& operator=(const IniFile&) = delete;

  /// Reads a file; throws Error if it is missing, unreadable or malformed.
  explicit IniFile(const std::filesystem::path& path);
  /// Parses text; `name` stands for the file name in messages.
  IniFile(const std::string& text, const std::string& name);

  /// Declares a section, which may be absent from the file; `meaning` goes into documentation().
  /// The section must not outlive this file.
  IniSection section(const std::string& name, const std::string& meaning = "");

  /// Whether the file holds `[name]`.
  bool has_section(const std::string& name) const;
  /// Sections of the file in order of appearance.
  std::vector<std::string> sections() const;

  /// Sets or replaces a value, as from the command line; messages then name `origin`.
  void override_value(const std::string& section, const std::string& key, const std::string& value,
                      const std::string& origin = "command line");

  /// Throws Error naming every section and key of the file that nobody declared, with the nearest
  /// declared name.
  void reject_unknown() const;

  /// All declared sections and keys as a valid INI: meaning, type, range and default as comments,
  /// and the value in effect.
  std::string documentation() const;

  const std::string& name() const { return name_; }
  /// Relative paths in the file are relative to this folder.
  std::filesystem::path directory() const;

 private:
  friend class IniSection;

  struct Entry {
    std::string key;
    std::string value;
    std::string where;  // "file:line"
  };
  struct Declaration {
    std::string key, type, default_value, value, meaning;
  };
  struct Section {
    std::string name;
    std::string where;  // empty if not in the file
    std::string meaning;
    bool declared = false;
    std::vector<Entry> entries;
    std::vector<Declaration> declarations;
  };

  void parse(const std::string& text);
  void parse_line(const std::string& line, std::size_t line_number, Section*& current);
  const Section* find(const std::string& name) const;
  Section& find_or_add(const std::string& name);

  std::string name_ = "(defaults)";
  bool documenting_ = true;
  std::list<Section> sections_;  // a list: IniSection keeps a pointer
};

/// The keys of one section. `T` is bool, int, int64_t, uint64_t, double, std::string,
/// std::vector<double>, std::vector<int64_t> or std::vector<std::string>; vectors are separated by
/// spaces or commas. All functions throw Error as said at IniFile.
class IniSection {
 public:
  const std::string& name() const { return section_->name; }
  bool has(const std::string& key) const { return find(key) != nullptr; }
  /// Keys present in the file, in order.
  std::vector<std::string> keys() const;

  template <class T>
  T get(const std::string& key, const T& default_value, const std::string& meaning,
        const IniRange& range = kAnyNumber);
  std::string get(const std::string& key, const char* default_value, const std::string& meaning) {
    return get<std::string>(key, default_value, meaning);
  }

  /// A key without default.
  template <class T>
  T require(const std::string& key, const std::string& meaning, const IniRange& range = kAnyNumber);

  /// One word out of `choices`.
  std::string choice(const std::string& key, const std::string& default_value,
                     const std::vector<std::string>& choices, const std::string& meaning);

  /// An angle written in degrees, default in degrees; returns radians.
  double degrees(const std::string& key, double default_degrees, const std::string& meaning,
                 const IniRange& range_degrees = kAnyNumber);

  /// A path; if relative, taken relative to the folder of the INI file. Empty stays empty.
  std::string path(const std::string& key, const std::string& default_value,
                   const std::string& meaning);

  /// Throws Error naming file, line, section and key: for checks that span several keys.
  [[noreturn]] void fail(const std::string& key, const std::string& why) const;

 private:
  friend class IniFile;
  IniSection(IniFile& file, IniFile::Section& section) : file_(&file), section_(&section) {}

  const IniFile::Entry* find(const std::string& key) const;
  const IniFile::Entry& find_required(const std::string& key) const;
  void declare(IniFile::Declaration declaration);
  template <class T>
  T parse(const IniFile::Entry& entry, const IniRange& range) const;

  IniFile* file_;
  IniFile::Section* section_;
};

/// The candidate nearest to `word` by edit distance, or "" if none is near enough to suggest.
std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace hybrid
