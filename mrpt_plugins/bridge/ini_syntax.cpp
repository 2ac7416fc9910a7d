// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/detail/ini_syntax.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/bridge/ini_text.h"

namespace hybrid {
namespace {

constexpr std::size_t kLongestValue = 65536;  // characters, definitions expanded

/// Names that `@define` has defined so far.
class Definitions {
 public:
  /// Reads a line `@define NAME VALUE`.
  void add(const std::string& line, const std::string& where) {
    const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
    const std::string rest = ini::trimmed(std::string_view(line).substr(end));
    const std::size_t name_end = std::min(rest.find_first_of(" \t"), rest.size());
    if (line.substr(0, end) != "@define" || name_end == 0) {
      throw Error(
          fmt::format("{}: expected '@define NAME VALUE', found {}", where, in_quotes(line)));
    }
    const std::string value = ini::trimmed(std::string_view(rest).substr(name_end));
    values_[rest.substr(0, name_end)] = expanded(value, where);
  }

  /// The text with definitions expanded.
  std::string expanded(std::string_view text, const std::string& where) const {
    std::string out;
    while (!text.empty()) {
      const std::size_t dollar = std::min(text.find('$'), text.size());
      out += text.substr(0, dollar);
      text.remove_prefix(dollar);
      for (const std::string_view live : {"$env{", "$eval{"}) {
        if (text.substr(0, live.size()) != live) continue;
        throw Error(fmt::format("{}: {}}} is not supported: write the value", where, live));
      }
      if (text.substr(0, 2) == "${") {
        const std::size_t end = text.find('}');
        out += value_of(ini::trimmed(text.substr(2, std::min(end, text.size()) - 2)), where);
        text.remove_prefix(std::min(end, text.size() - 1) + 1);
      } else if (!text.empty()) {
        out += text.front();
        text.remove_prefix(1);
      }
      if (out.size() <= kLongestValue) continue;
      throw Error(fmt::format("{}: a value of more than {} bytes", where, kLongestValue));
    }
    return out;
  }

 private:
  const std::string& value_of(const std::string& name, const std::string& where) const {
    const auto found = values_.find(name);
    if (found != values_.end()) return found->second;
    throw Error(fmt::format("{}: ${{{}}} is not defined before", where, escaped(name)));
  }

  std::unordered_map<std::string, std::string> values_;
};

IniLine parse_line(const std::string& line, const std::string& where) {
  if (line.front() == '[') {
    if (line.back() != ']')
      throw Error(fmt::format("{}: {} lacks its ']'", where, in_quotes(line)));
    return {true, ini::trimmed(std::string_view(line).substr(1, line.size() - 2)), "", where};
  }
  const std::size_t equals = line.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw Error(
        fmt::format("{}: expected '[section]' or 'key = value', found {}", where, in_quotes(line)));
  }
  return {false, ini::trimmed(std::string_view(line).substr(0, equals)),
          ini::trimmed(std::string_view(line).substr(equals + 1)), where};
}

/// Throws Error for control characters, which a terminal would obey.
void check_characters(std::string_view line, const TextReader& text) {
  const auto control = std::find_if(line.begin(), line.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte < 0x20 && c != '\t') || byte == 0x7f;
  });
  if (control == line.end()) return;
  throw Error(at_place(text.name(), text.line(), line,
                       static_cast<std::size_t>(control - line.begin()), "a control character"));
}

}  // namespace

std::vector<IniLine> parse_ini(std::string_view text, const std::string& name) {
  TextReader reader(text, name, {TextFormat::Cut::kWords, ""});
  std::vector<IniLine> lines;
  Definitions defined;
  std::string joined, where;
  for (std::string_view part; reader.next_line(part);) {
    check_characters(part, reader);
    const std::size_t first = part.find_first_not_of(" \t"), last = part.find_last_not_of(" \t");
    if (joined.empty() && first != std::string_view::npos) {
      where = fmt::format("{}:{}:{}", name, reader.line(), first + 1);
    }
    const bool continues = last != std::string_view::npos && part[last] == '\\';
    joined += part.substr(0, continues ? last : part.size());
    if (continues) continue;
    const std::string line = ini::trimmed(ini::without_comment(joined));
    joined.clear();
    if (line.empty()) continue;
    if (line.front() == '@') {
      defined.add(line, where);
    } else {
      lines.push_back(parse_line(defined.expanded(line, where), where));
    }
  }
  if (!ini::trimmed(joined).empty())
    throw Error(fmt::format("{}: the file ends behind a backslash", where));
  return lines;
}

}  // namespace hybrid
