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

/// The lines of an INI, without comments and with definitions expanded. A comment is a line that
/// starts with `#`, `;` or `//`, or the rest of a line from one of these after a space. A line that
/// ends in a backslash continues on the next one. After `@define NAME VALUE`, `${NAME}` stands for
/// the value. Throws Error "file:line:column: what" for any other line, for undefined names, for
/// control characters, and for MRPT's `$env{}` and `$eval{}`, which would let a file read the
/// environment and run programs.
std::vector<IniLine> parse_ini(std::string_view text, const std::string& name);

}  // namespace hybrid
