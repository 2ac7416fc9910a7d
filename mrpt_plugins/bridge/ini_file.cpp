// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/ini_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <numeric>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/bridge/detail/ini_syntax.h"
#include "mrpt_plugins/bridge/ini_text.h"
#include "mrpt_plugins/bridge/standard_input.h"

namespace hybrid {
namespace {

constexpr std::uint64_t kLargestIni = std::uint64_t{1} << 20;
constexpr std::size_t kProblems = 20;     // listed in one message
constexpr std::size_t kLongestName = 64;  // longest name for which a similar one is searched

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
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

/// The only program whose INIs have this section, or "".
std::string program_with(const std::string& section) {
  constexpr std::pair<const char*, const char*> kTold[] = {{"log", "hybrid-replay"},
                                                           {"experiment", "hybrid-experiment"},
                                                           {"world", "hybrid-simulate"},
                                                           {"online_selection", "hybrid-pgo"}};
  for (const auto& [name, program] : kTold) {
    if (ini::same_name(name, section)) return program;
  }
  return "";
}

std::string describe(const std::string& type, const Interval& range) {
  const char* not_equal = range.open ? "" : "=";
  std::string text = type;
  if (range.min > kAnyNumber.min) text += fmt::format(", >{} {}", not_equal, range.min);
  if (range.max < kAnyNumber.max) text += fmt::format(", <{} {}", not_equal, range.max);
  if (range.or_zero) text += ", or 0";
  return text;
}

template <class T>
bool all_in_range(const T& value, const Interval& range) {
  if constexpr (std::is_arithmetic_v<T>) {
    return range.contains(static_cast<double>(value));
  } else if constexpr (std::is_same_v<T, std::vector<double>> ||
                       std::is_same_v<T, std::vector<std::int64_t>>) {
    return std::all_of(value.begin(), value.end(),
                       [&](auto x) { return range.contains(static_cast<double>(x)); });
  } else {
    return true;
  }
}

}  // namespace

std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates) {
  std::string nearest;
  if (word.size() > kLongestName) return nearest;
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
  const std::string text = read_file(name_, kLargestIni);
  if (text.empty()) throw Error(fmt::format("{}: is empty", name_));
  parse(text);
}

IniFile::IniFile(const std::string& text, const std::string& name)
    : name_(name), documenting_(false) {
  parse(text);
}

std::filesystem::path IniFile::directory() const {
  return std::filesystem::path(name_).parent_path();
}

void IniFile::parse(const std::string& text) {
  Section* current = nullptr;
  for (IniLine& line : parse_ini(text, name_)) {
    if (line.is_section) {
      current = &find_or_add(line.name);
      if (current->where.empty()) current->where = line.where;
      continue;
    }
    if (current == nullptr) {
      throw Error(fmt::format("{}: key {} stands before the first [section]", line.where,
                              in_quotes(line.name)));
    }
    if (const Entry* entry = current->find(line.name)) {
      throw Error(fmt::format("{}: key {} of [{}] is already set at {}", line.where,
                              in_quotes(line.name), escaped(current->name), entry->where));
    }
    current->add({std::move(line.name), std::move(line.value), std::move(line.where)});
  }
}

const IniFile::Entry* IniFile::Section::find(const std::string& key) const {
  const auto found = places.find(lower_case(key));
  return found == places.end() ? nullptr : &entries[found->second];
}

void IniFile::Section::add(Entry entry) {
  places.emplace(lower_case(entry.key), entries.size());
  entries.push_back(std::move(entry));
}

const IniFile::Section* IniFile::find(const std::string& name) const {
  const auto found = places_.find(lower_case(name));
  return found == places_.end() ? nullptr : found->second;
}

IniFile::Section& IniFile::find_or_add(const std::string& name) {
  Section*& place = places_[lower_case(name)];
  if (place == nullptr) {
    place = &sections_.emplace_back();
    place->name = name;
  }
  return *place;
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

bool IniFile::declares(const std::string& section, const std::string& key) const {
  const Section* found = find(section);
  return found != nullptr && found->declared &&
         std::any_of(found->declarations.begin(), found->declarations.end(),
                     [&](const Declaration& d) { return ini::same_name(d.key, key); });
}

std::vector<std::string> IniFile::sections() const {
  std::vector<std::string> names;
  for (const Section& section : sections_) {
    if (!section.where.empty()) names.push_back(section.name);
  }
  return names;
}

void IniFile::reject_unknown() const {
  std::vector<std::string> known_sections;
  for (const Section& section : sections_) {
    if (section.declared) known_sections.push_back(section.name);
  }
  std::string problems;
  std::size_t count = 0;
  const auto add = [&](const auto& describe) {
    if (++count <= kProblems) problems += (count > 1 ? "\n" : "") + describe();
  };
  for (const Section& section : sections_) {
    if (!section.declared) {
      const std::string program = program_with(section.name);
      if (!program.empty()) {
        throw Error(fmt::format("{}: [{}] is a section of {}: this is an INI of that program",
                                section.where, section.name, program));
      }
      add([&] {
        return fmt::format("{}: unknown section [{}]{}", section.where, escaped(section.name),
                           suggestion(section.name, known_sections));
      });
      continue;
    }
    std::vector<std::string> known;
    for (const Declaration& declaration : section.declarations) known.push_back(declaration.key);
    for (const Entry& entry : section.entries) {
      const auto same = [&](const std::string& key) { return ini::same_name(key, entry.key); };
      if (std::any_of(known.begin(), known.end(), same)) continue;
      add([&] {
        return fmt::format("{}: [{}] has no key {}{}", entry.where, section.name,
                           in_quotes(entry.key), suggestion(entry.key, known));
      });
    }
  }
  if (count > kProblems) problems += fmt::format("\nand {} more like these", count - kProblems);
  if (count > 0) throw Error(problems);
}

std::string IniFile::documentation() const {
  std::string text;
  for (const Section& section : sections_) {
    if (!section.declared) continue;
    if (!section.meaning.empty()) text += fmt::format("# {}\n", section.meaning);
    text += fmt::format("[{}]\n", section.name);
    for (const Declaration& key : section.declarations) {
      text += fmt::format("# {} ({}; {})\n{} = {}\n", key.meaning, key.type, key.default_value,
                          key.key, key.absolute.empty() ? key.value : key.absolute);
    }
    text += "\n";
  }
  return text;
}

IniFile::Settings IniFile::settings() const {
  Settings settings;
  for (const Section& section : sections_) {
    if (!section.declared) continue;
    settings.emplace_back(section.name, std::vector<std::pair<std::string, std::string>>());
    for (const Declaration& key : section.declarations) {
      settings.back().second.emplace_back(key.key, key.value);
    }
  }
  return settings;
}

std::vector<std::string> IniSection::keys() const {
  std::vector<std::string> names;
  for (const auto& entry : section_->entries) names.push_back(entry.key);
  return names;
}

const IniFile::Entry* IniSection::find(const std::string& key) const {
  return section_->find(key);
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
  throw Error(about(key) + " " + why);
}

template <class T>
T IniSection::parse(const IniFile::Entry& entry, const Interval& range) const {
  T value{};
  const std::string type = describe(ini::TypeName<T>::kText, range);
  if (entry.value.empty() && !std::is_class_v<T>) fail(entry.key, "is empty; expected: " + type);
  if (!ini::parse(entry.value, value) || !all_in_range(value, range)) {
    fail(entry.key, fmt::format("= {} is not valid; expected: {}", in_quotes(entry.value), type));
  }
  return value;
}

template <class T>
T IniSection::get(const std::string& key, const T& default_value, const std::string& meaning,
                  const Interval& range) {
  const IniFile::Entry* entry = find(key);
  const T value = entry != nullptr ? parse<T>(*entry, range) : default_value;
  declare({key, describe(ini::TypeName<T>::kText, range), "default " + ini::format(default_value),
           ini::format(value), meaning});
  return value;
}

template <class T>
T IniSection::require(const std::string& key, const std::string& meaning, const Interval& range) {
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
    fail(key, fmt::format("= {} is not valid{}", in_quotes(value), suggestion(value, choices)));
  }
  declare({key, "one of: " + ini::format(choices), "default " + default_value, value, meaning});
  return value;
}

double IniSection::degrees(const std::string& key, double default_degrees,
                           const std::string& meaning, const Interval& range_degrees) {
  return get(key, default_degrees, meaning, range_degrees) * (M_PI / 180.0);
}

void IniSection::note_path(const std::string& key, const std::string& absolute) {
  for (IniFile::Declaration& declaration : section_->declarations) {
    if (ini::same_name(declaration.key, key)) declaration.absolute = absolute;
  }
}

std::string IniSection::path(const std::string& key, const std::string& default_value,
                             const std::string& meaning) {
  const std::string value = get(key, default_value, meaning);
  if (is_standard_input(value)) return value;
  const IniFile::Entry* entry = find(key);
  const bool from_file = entry != nullptr && entry->where.rfind(file_->name(), 0) == 0;
  std::string path = value;
  if (!value.empty() && !std::filesystem::path(value).is_absolute() && from_file) {
    path = (file_->directory() / value).lexically_normal().string();
  }
  if (!path.empty()) note_path(key, std::filesystem::absolute(path).lexically_normal().string());
  return path;
}

template bool IniSection::get(const std::string&, const bool&, const std::string&, const Interval&);
template int IniSection::get(const std::string&, const int&, const std::string&, const Interval&);
template std::int64_t IniSection::get(const std::string&, const std::int64_t&, const std::string&,
                                      const Interval&);
template std::uint64_t IniSection::get(const std::string&, const std::uint64_t&, const std::string&,
                                       const Interval&);
template double IniSection::get(const std::string&, const double&, const std::string&,
                                const Interval&);
template std::string IniSection::get(const std::string&, const std::string&, const std::string&,
                                     const Interval&);
template std::vector<double> IniSection::get(const std::string&, const std::vector<double>&,
                                             const std::string&, const Interval&);
template std::vector<std::int64_t> IniSection::get(const std::string&,
                                                   const std::vector<std::int64_t>&,
                                                   const std::string&, const Interval&);
template std::vector<std::string> IniSection::get(const std::string&,
                                                  const std::vector<std::string>&,
                                                  const std::string&, const Interval&);
template int IniSection::require(const std::string&, const std::string&, const Interval&);
template std::int64_t IniSection::require(const std::string&, const std::string&, const Interval&);
template double IniSection::require(const std::string&, const std::string&, const Interval&);
template std::string IniSection::require(const std::string&, const std::string&, const Interval&);
template std::vector<double> IniSection::require(const std::string&, const std::string&,
                                                 const Interval&);
template std::vector<std::string> IniSection::require(const std::string&, const std::string&,
                                                      const Interval&);

}  // namespace hybrid
