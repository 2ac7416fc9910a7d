// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/ini_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "libhybrid/io/parse_number.h"

namespace hybrid::ini {
namespace {

bool is_space(char c) {
  return std::isspace(static_cast<unsigned char>(c)) != 0;
}

template <class T>
bool parse_list(const std::string& text, std::vector<T>& out) {
  out.clear();
  for (const std::string& word : words(text)) {
    T value{};
    if (!parse(word, value)) return false;
    out.push_back(value);
  }
  return true;
}

template <class T>
std::string format_list(const std::vector<T>& values) {
  std::string text;
  for (const T& value : values) text += (text.empty() ? "" : " ") + format(value);
  return text;
}

}  // namespace

std::string trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return std::string(text);
}

std::string without_comment(std::string_view line) {
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (i > 0 && !is_space(line[i - 1])) continue;
    if (line[i] == '#' || line[i] == ';' || line.substr(i, 2) == "//")
      return std::string(line.substr(0, i));
  }
  return std::string(line);
}

bool same_name(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

std::vector<std::string> words(std::string_view text) {
  std::vector<std::string> found;
  std::string word;
  for (const char c : text) {
    if (!is_space(c) && c != ',') {
      word += c;
    } else if (!word.empty()) {
      found.push_back(std::exchange(word, {}));
    }
  }
  if (!word.empty()) found.push_back(word);
  return found;
}

bool parse(const std::string& text, bool& out) {
  for (const char* word : {"true", "yes", "on", "1"}) {
    if (same_name(text, word)) return out = true;
  }
  for (const char* word : {"false", "no", "off", "0"}) {
    if (same_name(text, word)) return !(out = false);
  }
  return false;
}

bool parse(const std::string& text, int& out) {
  return parse_number(text, out);
}
bool parse(const std::string& text, std::int64_t& out) {
  return parse_number(text, out);
}
bool parse(const std::string& text, std::uint64_t& out) {
  return parse_number(text, out);
}
bool parse(const std::string& text, double& out) {
  return parse_number(text, out) && std::isfinite(out);
}
bool parse(const std::string& text, std::string& out) {
  out = text;
  return true;
}
bool parse(const std::string& text, std::vector<double>& out) {
  return parse_list(text, out);
}
bool parse(const std::string& text, std::vector<std::int64_t>& out) {
  return parse_list(text, out);
}
bool parse(const std::string& text, std::vector<std::string>& out) {
  out = words(text);
  return true;
}

std::string format(bool value) {
  return value ? "true" : "false";
}
std::string format(int value) {
  return std::to_string(value);
}
std::string format(std::int64_t value) {
  return std::to_string(value);
}
std::string format(std::uint64_t value) {
  return std::to_string(value);
}
std::string format(double value) {
  return fmt::format("{}", value);
}
std::string format(const std::string& value) {
  return value;
}
std::string format(const std::vector<double>& value) {
  return format_list(value);
}
std::string format(const std::vector<std::int64_t>& value) {
  return format_list(value);
}
std::string format(const std::vector<std::string>& value) {
  return format_list(value);
}

}  // namespace hybrid::ini
