// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/ini_file.h"

namespace HYBRID_API hybrid {

/// The table that T::describe fills: reads options from keys, or the one of a name.
template <class T>
struct OptionReader {
  IniSection section;
  T& options;
  std::string about, only = {};
  bool has_read = false;

  template <class Member, class Owner>
  void option(const char* name, Member Owner::*member, const char* meaning) {
    option(name, member, kAnyNumber, meaning);
  }
  template <class Member, class Owner>
  void option(const char* name, Member Owner::*member, const Interval& interval,
              const char* meaning, const char* key = nullptr) {
    if (!wants(name)) return;
    section.read(key != nullptr ? key : name, options.*member, about + meaning, interval);
  }
  template <class Member, class Owner, std::size_t n>
  void choice(const char* name, Member Owner::*member, const char* meaning,
              const Named<Member> (&choices)[n]) {
    if (!wants(name)) return;
    std::string word;
    std::vector<std::string> words;
    for (const Named<Member>& one : choices) {
      words.emplace_back(one.name);
      if (one.value == options.*member) word = one.name;
    }
    word = section.choice(name, word, words, about + meaning);
    for (const Named<Member>& one : choices) {
      if (one.name == word) options.*member = one.value;
    }
  }
  template <class Member, class Owner>
  void field(const char*, Member Owner::*, const char*) {}

  bool wants(const char* name) {
    const bool wanted = only.empty() || only == name;
    has_read = has_read || wanted;
    return wanted;
  }
};

/// Reads the options of a struct from keys of a section, as T::describe tells them; their present
/// values are the defaults. `about` is put before what they mean.
template <class T>
void read_options(IniSection section, T& options, const std::string& about = "") {
  OptionReader<T> reader{section, options, about};
  T::describe(reader);
}

/// Reads the one of this name alone; throws Error where the struct has none.
template <class T>
void read_option(IniSection section, T& options, const std::string& name,
                 const std::string& about = "") {
  OptionReader<T> reader{section, options, about, name};
  T::describe(reader);
  if (!reader.has_read) throw Error("there is no option " + name);
}

}  // namespace hybrid
