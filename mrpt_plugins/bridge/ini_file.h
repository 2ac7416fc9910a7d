// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "libhybrid/core/option.h"
#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

class IniSection;

// Plausible ranges of further units, beside those of libhybrid/core/option.h.
inline constexpr Interval kCoordinate{-1e6, 1e6};  ///< [m]
inline constexpr Interval kSigmaDegrees{1e-5, 360.0};
inline constexpr Interval kSigmaRadians{1e-7, 6.3};
inline constexpr Interval kTurn{-360.0, 360.0};  ///< [deg]

/// A strict INI file of at most 1 MiB. Its syntax is that of parse_ini(): that of
/// mrpt::config::CConfigFile without `$env{}` and `$eval{}`. Names ignore case. Unlike MRPT, it
/// throws an Error that names file, line, section and key for unknown or repeated keys, wrong
/// types, NaN, numbers out of range, unclosed sections and a missing file.
///
/// Code that reads a key declares it: IniSection::get() takes type, default, range and meaning.
/// After all keys are read, reject_unknown() throws if the file holds an undeclared key, and
/// documentation() lists the declared ones. Not copyable: sections point to their file.
class IniFile {
 public:
  /// An empty file for documentation(): required keys return a zero value and do not throw.
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
  /// Whether code has declared a key.
  bool declares(const std::string& section, const std::string& key) const;
  /// Sections of the file in order of appearance.
  std::vector<std::string> sections() const;

  /// Sets or replaces a value, for example from the command line. Messages then name `origin`.
  void override_value(const std::string& section, const std::string& key, const std::string& value,
                      const std::string& origin = "command line");
  /// The same for texts SECTION.KEY=VALUE, as of --set; Error for any other. The name of a section
  /// holds no dot here, but that of a robot: robot.NAME.KEY=VALUE.
  void override_values(const std::vector<std::string>& settings);

  /// Warnings for the user, such as deprecated names with their new ones.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Throws Error naming every undeclared section and key of the file, with the nearest declared
  /// name.
  void reject_unknown() const;

  /// All declared sections and keys as a valid INI: meaning, type, range and default as comments,
  /// and the value in effect; paths are absolute, so that it reads back from any folder.
  std::string documentation() const;

  /// Declared sections with their keys and the values in effect, in order.
  using Settings =
      std::vector<std::pair<std::string, std::vector<std::pair<std::string, std::string>>>>;
  Settings settings() const;

  const std::string& name() const { return name_; }
  /// Relative paths in the file are relative to this folder.
  std::filesystem::path directory() const;

 private:
  friend class IniSection;

  struct Entry {
    std::string key;
    std::string value;
    std::string where;          // "file:line:column"
    bool overrides = false;     // set by override_value()
    std::string old_name = {};  // deprecated "[section] key" that the file used, or empty
  };
  struct Declaration {
    std::string key, type, default_value, value, meaning;
    std::string absolute = {};  // path, so that documentation() is valid in any folder
  };
  struct Section {
    std::string name;
    std::string where;  // empty if not in the file
    std::string meaning;
    bool declared = false;
    std::vector<Entry> entries;
    std::vector<Declaration> declarations;
    std::unordered_map<std::string, std::size_t> places;  // of entries, by name in lower case

    const Entry* find(const std::string& key) const;
    void add(Entry entry);
    void remove(const std::string& key);
  };

  void parse(const std::string& text);
  const Section* find(const std::string& name) const;
  Section& find_or_add(const std::string& name);

  std::string name_ = "(defaults)";
  bool documenting_ = true;
  std::vector<std::string> warnings_;
  std::list<Section> sections_;                       // a list: IniSection keeps a pointer
  std::unordered_map<std::string, Section*> places_;  // by name in lower case
};

/// The keys of one section. `T` is bool, int, int64_t, uint64_t, double, std::string,
/// std::vector<double>, std::vector<int64_t> or std::vector<std::string>; vectors are separated by
/// spaces or commas. All functions throw Error as IniFile does.
class IniSection {
 public:
  const std::string& name() const { return section_->name; }
  bool has(const std::string& key) const { return find(key) != nullptr; }
  /// Whether the value of the key comes from the command line.
  bool is_overridden(const std::string& key) const;
  /// Where the value of a key stands: file, line and column, or "command line"; "" if nowhere.
  std::string place(const std::string& key) const;
  /// Keys present in the file, in order.
  std::vector<std::string> keys() const;

  template <class T>
  T get(const std::string& key, const T& default_value, const std::string& meaning,
        const Interval& range = kAnyNumber);
  std::string get(const std::string& key, const char* default_value, const std::string& meaning) {
    return get<std::string>(key, default_value, meaning);
  }
  /// Reads a key whose default is the present value.
  template <class T>
  void read(const std::string& key, T& value, const std::string& meaning,
            const Interval& range = kAnyNumber) {
    value = get(key, value, meaning, range);
  }

  /// A key without default.
  template <class T>
  T require(const std::string& key, const std::string& meaning, const Interval& range = kAnyNumber);

  /// One word out of `choices`.
  std::string choice(const std::string& key, const std::string& default_value,
                     const std::vector<std::string>& choices, const std::string& meaning);

  /// An angle written in degrees, default in degrees; returns radians.
  double degrees(const std::string& key, double default_degrees, const std::string& meaning,
                 const Interval& range_degrees = kAnyNumber);

  /// A path; if relative, taken relative to the folder of the INI file. Empty stays empty, and "-"
  /// standard input.
  std::string path(const std::string& key, const std::string& default_value,
                   const std::string& meaning);

  /// Declares `old_key` as a deprecated name of `key`, in this section or in `old_section` if
  /// given. A value under the old name counts for the new one, with a warning. Call it before the
  /// key is read. Throws Error if both names are given in the file, or both on the command line;
  /// otherwise the command line overrides the file.
  void replaces(const std::string& key, const std::string& old_key,
                const std::string& old_section = "");

  /// The same for a key that had several meanings: its value counts for each of `keys`.
  void replace_all(const std::vector<std::string>& keys, const std::string& old_key,
                   const std::string& old_section = "");

  /// Adds a warning that names file, line, section and key.
  void warn(const std::string& key, const std::string& what);

  /// Throws Error naming file, line, section and key: for checks that span several keys.
  [[noreturn]] void fail(const std::string& key, const std::string& why) const;

 private:
  friend class IniFile;
  IniSection(IniFile& file, IniFile::Section& section) : file_(&file), section_(&section) {}

  const IniFile::Entry* find(const std::string& key) const;
  const IniFile::Entry& find_required(const std::string& key) const;
  std::string about(const std::string& key) const;
  void declare(IniFile::Declaration declaration);
  void note_path(const std::string& key, const std::string& absolute);
  template <class T>
  T parse(const IniFile::Entry& entry, const Interval& range) const;

  IniFile* file_;
  IniFile::Section* section_;
};

/// The candidate nearest to `word` by edit distance, or "" if none is near enough to suggest.
std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace hybrid
