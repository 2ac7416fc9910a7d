// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/ini_file.h"

#include <fmt/format.h>
#include <mrpt/config/config_parser.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <numeric>
#include <optional>
#include <sstream>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/ini_text.h"

namespace hybrid {
namespace {

std::string read_text(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) throw Error(fmt::format("{}: no such file", path.string()));
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  if (!std::filesystem::is_regular_file(path) || !file || !(text << file.rdbuf()).good()) {
    throw Error(fmt::format("{}: cannot be read, or is empty", path.string()));
  }
  return text.str();
}

/// MRPT joins lines that end in a backslash: for each joined line, the number of its first line.
std::vector<std::size_t> first_lines(const std::string& text) {
  std::vector<std::size_t> numbers;
  std::istringstream lines(text);
  bool continues = false;
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (!continues) numbers.push_back(number);
    const std::string content = ini::trimmed(line);
    continues = !content.empty() && content.back() == '\\';
  }
  return numbers;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const bool same = std::tolower(static_cast<unsigned char>(a[i])) ==
                        std::tolower(static_cast<unsigned char>(b[j]));
      const std::size_t replaced = diagonal + (same ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

std::string suggestion(const std::string& word, const std::vector<std::string>& known) {
  const std::string nearest = nearest_name(word, known);
  if (!nearest.empty()) return fmt::format("; did you mean '{}'?", nearest);
  return fmt::format("; known are: {}", ini::format(known));
}

std::string describe(const std::string& type, const IniRange& range) {
  const char* not_equal = range.open ? "" : "=";
  std::string text = type;
  if (std::isfinite(range.min)) text += fmt::format(", >{} {}", not_equal, range.min);
  if (std::isfinite(range.max)) text += fmt::format(", <{} {}", not_equal, range.max);
  return text;
}

bool in_range(double value, const IniRange& range) {
  if (range.open) return value > range.min && value < range.max;
  return value >= range.min && value <= range.max;
}

template <class T>
bool all_in_range(const T& value, const IniRange& range) {
  if constexpr (std::is_arithmetic_v<T>) {
    return in_range(static_cast<double>(value), range);
  } else if constexpr (std::is_same_v<T, std::vector<double>> ||
                       std::is_same_v<T, std::vector<std::int64_t>>) {
    return std::all_of(value.begin(), value.end(),
                       [&](auto x) { return in_range(static_cast<double>(x), range); });
  } else {
    return true;
  }
}

}  // namespace

std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates) {
  std::string nearest;
  std::size_t smallest = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < smallest && distance < candidate.size()) {
      smallest = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

IniFile::IniFile(const std::filesystem::path& path) : name_(path.string()), documenting_(false) {
  parse(read_text(path));
}

IniFile::IniFile(const std::string& text, const std::string& name)
    : name_(name), documenting_(false) {
  parse(text);
}

std::filesystem::path IniFile::directory() const {
  return std::filesystem::path(name_).parent_path();
}

void IniFile::parse(const std::string& text) {
  std::string expanded;
  try {
    expanded = mrpt::config::config_parser(text);
  } catch (const std::exception& e) {
    throw Error(fmt::format("{}: {}", name_, e.what()));
  }
  const std::vector<std::size_t> numbers = first_lines(text);
  std::istringstream lines(expanded);
  Section* current = nullptr;
  std::size_t i = 0;
  for (std::string line; std::getline(lines, line); ++i) {
    line = ini::trimmed(ini::without_comment(line));
    if (!line.empty()) parse_line(line, i < numbers.size() ? numbers[i] : numbers.back(), current);
  }
}

void IniFile::parse_line(const std::string& line, std::size_t line_number, Section*& current) {
  const std::string where = fmt::format("{}:{}", name_, line_number);
  if (line.front() == '[') {
    if (line.back() != ']') throw Error(fmt::format("{}: '{}' lacks its ']'", where, line));
    current = &find_or_add(ini::trimmed(std::string_view(line).substr(1, line.size() - 2)));
    if (current->where.empty()) current->where = where;
    return;
  }
  const std::size_t equals = line.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw Error(fmt::format("{}: expected '[section]' or 'key = value', found '{}'", where, line));
  }
  const std::string key = ini::trimmed(std::string_view(line).substr(0, equals));
  if (current == nullptr) {
    throw Error(fmt::format("{}: key '{}' stands before the first [section]", where, key));
  }
  for (const Entry& entry : current->entries) {
    if (!ini::same_name(entry.key, key)) continue;
    throw Error(fmt::format("{}: key '{}' of [{}] is already set at {}", where, key, current->name,
                            entry.where));
  }
  current->entries.push_back({key, ini::trimmed(std::string_view(line).substr(equals + 1)), where});
}

const IniFile::Section* IniFile::find(const std::string& name) const {
  for (const Section& section : sections_) {
    if (ini::same_name(section.name, name)) return &section;
  }
  return nullptr;
}

IniFile::Section& IniFile::find_or_add(const std::string& name) {
  for (Section& section : sections_) {
    if (ini::same_name(section.name, name)) return section;
  }
  return sections_.emplace_back(Section{name, "", "", false, {}, {}});
}

IniSection IniFile::section(const std::string& name, const std::string& meaning) {
  Section& section = find_or_add(name);
  section.declared = true;
  if (!meaning.empty()) section.meaning = meaning;
  return {*this, section};
}

bool IniFile::has_section(const std::string& name) const {
  const Section* section = find(name);
  return section != nullptr && !section->where.empty();
}

std::vector<std::string> IniFile::sections() const {
  std::vector<std::string> names;
  for (const Section& section : sections_) {
    if (!section.where.empty()) names.push_back(section.name);
  }
  return names;
}

void IniFile::override_value(const std::string& section, const std::string& key,
                             const std::string& value, const std::string& origin) {
  Section& target = find_or_add(section);
  if (target.where.empty()) target.where = origin;
  for (Entry& entry : target.entries) {
    if (!ini::same_name(entry.key, key)) continue;
    entry.value = value;
    entry.where = origin;
    return;
  }
  target.entries.push_back({key, value, origin});
}

void IniFile::reject_unknown() const {
  std::vector<std::string> known_sections;
  for (const Section& section : sections_) {
    if (section.declared) known_sections.push_back(section.name);
  }
  std::string problems;
  for (const Section& section : sections_) {
    if (!section.declared) {
      problems += fmt::format("{}: unknown section [{}]{}\n", section.where, section.name,
                              suggestion(section.name, known_sections));
      continue;
    }
    std::vector<std::string> known;
    for (const Declaration& declaration : section.declarations) known.push_back(declaration.key);
    for (const Entry& entry : section.entries) {
      const auto same = [&](const std::string& key) { return ini::same_name(key, entry.key); };
      if (std::any_of(known.begin(), known.end(), same)) continue;
      problems += fmt::format("{}: [{}] has no key '{}'{}\n", entry.where, section.name, entry.key,
                              suggestion(entry.key, known));
    }
  }
  if (problems.empty()) return;
  problems.pop_back();
  throw Error(problems);
}

std::string IniFile::documentation() const {
  std::string text;
  for (const Section& section : sections_) {
    if (!section.declared) continue;
    if (!section.meaning.empty()) text += fmt::format("# {}\n", section.meaning);
    text += fmt::format("[{}]\n", section.name);
    for (const Declaration& key : section.declarations) {
      text += fmt::format("# {} ({}; {})\n{} = {}\n", key.meaning, key.type, key.default_value,
                          key.key, key.value);
    }
    text += "\n";
  }
  return text;
}

std::vector<std::string> IniSection::keys() const {
  std::vector<std::string> names;
  for (const auto& entry : section_->entries) names.push_back(entry.key);
  return names;
}

const IniFile::Entry* IniSection::find(const std::string& key) const {
  for (const auto& entry : section_->entries) {
    if (ini::same_name(entry.key, key)) return &entry;
  }
  return nullptr;
}

const IniFile::Entry& IniSection::find_required(const std::string& key) const {
  const IniFile::Entry* entry = find(key);
  if (entry == nullptr) fail(key, "is required but missing");
  return *entry;
}

void IniSection::declare(IniFile::Declaration declaration) {
  for (auto& known : section_->declarations) {
    if (!ini::same_name(known.key, declaration.key)) continue;
    known = std::move(declaration);
    return;
  }
  section_->declarations.push_back(std::move(declaration));
}

void IniSection::fail(const std::string& key, const std::string& why) const {
  const IniFile::Entry* entry = find(key);
  const std::string& section_where = section_->where.empty() ? file_->name() : section_->where;
  throw Error(fmt::format("{}: [{}] {} {}", entry != nullptr ? entry->where : section_where,
                          section_->name, key, why));
}

template <class T>
T IniSection::parse(const IniFile::Entry& entry, const IniRange& range) const {
  T value{};
  const std::string type = describe(ini::TypeName<T>::kText, range);
  if (entry.value.empty() && !std::is_class_v<T>) fail(entry.key, "is empty; expected: " + type);
  if (!ini::parse(entry.value, value) || !all_in_range(value, range)) {
    fail(entry.key, fmt::format("= '{}' is not valid; expected: {}", entry.value, type));
  }
  return value;
}

template <class T>
T IniSection::get(const std::string& key, const T& default_value, const std::string& meaning,
                  const IniRange& range) {
  const IniFile::Entry* entry = find(key);
  const T value = entry != nullptr ? parse<T>(*entry, range) : default_value;
  declare({key, describe(ini::TypeName<T>::kText, range), "default " + ini::format(default_value),
           ini::format(value), meaning});
  return value;
}

template <class T>
T IniSection::require(const std::string& key, const std::string& meaning, const IniRange& range) {
  const bool absent = file_->documenting_ && find(key) == nullptr;
  const T value = absent ? T{} : parse<T>(find_required(key), range);
  if constexpr (std::is_class_v<T>) {
    if (!absent && value.empty()) fail(key, "is required but empty");
  }
  declare({key, describe(ini::TypeName<T>::kText, range), "required",
           absent ? "" : ini::format(value), meaning});
  return value;
}

std::string IniSection::choice(const std::string& key, const std::string& default_value,
                               const std::vector<std::string>& choices,
                               const std::string& meaning) {
  const IniFile::Entry* entry = find(key);
  std::string value = entry != nullptr ? entry->value : default_value;
  const auto found = std::find_if(choices.begin(), choices.end(), [&](const std::string& choice) {
    return ini::same_name(choice, value);
  });
  if (found != choices.end()) {
    value = *found;
  } else {
    fail(key, fmt::format("= '{}' is not valid{}", value, suggestion(value, choices)));
  }
  declare({key, "one of: " + ini::format(choices), "default " + default_value, value, meaning});
  return value;
}

double IniSection::degrees(const std::string& key, double default_degrees,
                           const std::string& meaning, const IniRange& range_degrees) {
  return get(key, default_degrees, meaning, range_degrees) * (M_PI / 180.0);
}

std::string IniSection::path(const std::string& key, const std::string& default_value,
                             const std::string& meaning) {
  const std::string value = get(key, default_value, meaning);
  const IniFile::Entry* entry = find(key);
  const bool from_file = entry != nullptr && entry->where.rfind(file_->name(), 0) == 0;
  if (value.empty() || std::filesystem::path(value).is_absolute() || !from_file) return value;
  return (file_->directory() / value).lexically_normal().string();
}

template bool IniSection::get(const std::string&, const bool&, const std::string&, const IniRange&);
template int IniSection::get(const std::string&, const int&, const std::string&, const IniRange&);
template std::int64_t IniSection::get(const std::string&, const std::int64_t&, const std::string&,
                                      const IniRange&);
template std::uint64_t IniSection::get(const std::string&, const std::uint64_t&, const std::string&,
                                       const IniRange&);
template double IniSection::get(const std::string&, const double&, const std::string&,
                                const IniRange&);
template std::string IniSection::get(const std::string&, const std::string&, const std::string&,
                                     const IniRange&);
template std::vector<double> IniSection::get(const std::string&, const std::vector<double>&,
                                             const std::string&, const IniRange&);
template std::vector<std::int64_t> IniSection::get(const std::string&,
                                                   const std::vector<std::int64_t>&,
                                                   const std::string&, const IniRange&);
template std::vector<std::string> IniSection::get(const std::string&,
                                                  const std::vector<std::string>&,
                                                  const std::string&, const IniRange&);
template int IniSection::require(const std::string&, const std::string&, const IniRange&);
template std::int64_t IniSection::require(const std::string&, const std::string&, const IniRange&);
template double IniSection::require(const std::string&, const std::string&, const IniRange&);
template std::string IniSection::require(const std::string&, const std::string&, const IniRange&);
template std::vector<double> IniSection::require(const std::string&, const std::string&,
                                                 const IniRange&);
template std::vector<std::string> IniSection::require(const std::string&, const std::string&,
                                                      const IniRange&);

}  // namespace hybrid
