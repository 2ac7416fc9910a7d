// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Changes to an INI after reading: values of the command line, and deprecated names.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/bridge/ini_text.h"

namespace hybrid {

void IniFile::override_value(const std::string& section, const std::string& key,
                             const std::string& value, const std::string& origin) {
  Section& target = find_or_add(section);
  if (target.where.empty()) target.where = origin;
  target.remove(key);
  target.add({key, value, origin, true});
}

void IniFile::override_values(const std::vector<std::string>& settings) {
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    std::size_t dot = setting.find('.');
    if (dot != std::string::npos && ini::same_name(setting.substr(0, dot), "robot")) {
      dot = setting.find('.', dot + 1);
    }
    if (equals == std::string::npos || dot == std::string::npos || dot > equals || dot == 0 ||
        dot + 1 == equals) {
      throw Error("--set " + setting + ": expected SECTION.KEY=VALUE");
    }
    override_value(setting.substr(0, dot), setting.substr(dot + 1, equals - dot - 1),
                   setting.substr(equals + 1));
  }
}

void IniFile::Section::remove(const std::string& key) {
  entries.erase(std::remove_if(entries.begin(), entries.end(),
                               [&](const Entry& entry) { return ini::same_name(entry.key, key); }),
                entries.end());
  std::vector<Entry> kept = std::exchange(entries, {});
  places.clear();
  for (Entry& entry : kept) add(std::move(entry));
}

void IniSection::replaces(const std::string& key, const std::string& old_key,
                          const std::string& old_section) {
  replace_all({key}, old_key, old_section);
}

void IniSection::replace_all(const std::vector<std::string>& keys, const std::string& old_key,
                             const std::string& old_section) {
  const std::string& section = old_section.empty() ? name() : old_section;
  const IniFile::Section* source = file_->find(section);
  const IniFile::Entry* old = source == nullptr ? nullptr : source->find(old_key);
  if (old == nullptr) return;
  IniFile::Entry entry = *old;
  entry.old_name = fmt::format("[{}] {}", source->name, old->key);
  file_->warnings_.push_back(fmt::format("{}: {} is now [{}] {}", entry.where, entry.old_name,
                                         name(), fmt::join(keys, ", ")));
  const auto is_overridden = [&](const std::string& key) {
    const IniFile::Entry* present = find(key);
    return present != nullptr && present->overrides;
  };
  for (const std::string& key : keys) {
    if (find(key) == nullptr || is_overridden(key) != entry.overrides) continue;
    fail(key, fmt::format("is given twice: {} at {} is its old name", entry.old_name, entry.where));
  }
  file_->find_or_add(section).remove(old_key);
  if (section_->where.empty()) section_->where = entry.where;
  for (const std::string& key : keys) {
    if (is_overridden(key)) continue;
    section_->remove(key);
    entry.key = key;
    section_->add(entry);
  }
}

bool IniSection::is_overridden(const std::string& key) const {
  const IniFile::Entry* entry = find(key);
  return entry != nullptr && entry->overrides;
}

std::string IniSection::place(const std::string& key) const {
  const IniFile::Entry* entry = find(key);
  return entry == nullptr ? "" : entry->where;
}

std::string IniSection::about(const std::string& key) const {
  const IniFile::Entry* entry = find(key);
  const std::string& section_where = section_->where.empty() ? file_->name() : section_->where;
  const bool renamed = entry != nullptr && !entry->old_name.empty();
  return fmt::format("{}: [{}] {}{}", entry != nullptr ? entry->where : section_where, name(), key,
                     renamed ? " (given as " + entry->old_name + ")" : "");
}

void IniSection::warn(const std::string& key, const std::string& what) {
  file_->warnings_.push_back(about(key) + " " + what);
}

}  // namespace hybrid
