// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace hybrid {

/// A line `[name]` or `key = value` of an INI.
struct IniLine {
  bool is_section = false;
  std::string name;   ///< of the section or the key
  std::string value;  ///< of the key
  std::string where;  ///< "file:line:column"
};

/// The lines of an INI, without comments and with what is defined put in: a comment is a line that
/// starts with `#`, `;` or `//`, or the rest of a line from one of these after a space; a line that
/// ends in a backslash goes on in the next; after `@define NAME VALUE`, `${NAME}` stands for the
/// value. Throws Error "file:line:column: what" for anything else, for names that are not defined,
/// for MRPT's `$env{}` and `$eval{}`, which would let a file read the environment and run
/// programs, and for control characters.
std::vector<IniLine> parse_ini(std::string_view text, const std::string& name);

}  // namespace hybrid
