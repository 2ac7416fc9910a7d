// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {
/// Conversions between INI text and typed values, used by IniFile.
namespace ini {

std::string trimmed(std::string_view text);
/// Drops the rest of the line from `//`, `#` or `;` where these start the line or follow a space.
std::string without_comment(std::string_view line);
bool same_name(std::string_view a, std::string_view b);
/// Words separated by spaces or commas.
std::vector<std::string> words(std::string_view text);

/// True if the whole of `text` is one value of the type of `out`. NaN and infinity are rejected.
bool parse(const std::string& text, bool& out);
bool parse(const std::string& text, int& out);
bool parse(const std::string& text, std::int64_t& out);
bool parse(const std::string& text, std::uint64_t& out);
bool parse(const std::string& text, double& out);
bool parse(const std::string& text, std::string& out);
bool parse(const std::string& text, std::vector<double>& out);
bool parse(const std::string& text, std::vector<std::int64_t>& out);
bool parse(const std::string& text, std::vector<std::string>& out);

/// The shortest text that parses back to the same value.
std::string format(bool value);
std::string format(int value);
std::string format(std::int64_t value);
std::string format(std::uint64_t value);
std::string format(double value);
std::string format(const std::string& value);
std::string format(const std::vector<double>& value);
std::string format(const std::vector<std::int64_t>& value);
std::string format(const std::vector<std::string>& value);

template <class T>
struct TypeName;
template <>
struct TypeName<bool> {
  static constexpr const char* kText = "true or false";
};
template <>
struct TypeName<int> {
  static constexpr const char* kText = "whole number";
};
template <>
struct TypeName<std::int64_t> {
  static constexpr const char* kText = "whole number";
};
template <>
struct TypeName<std::uint64_t> {
  static constexpr const char* kText = "whole number >= 0";
};
template <>
struct TypeName<double> {
  static constexpr const char* kText = "number";
};
template <>
struct TypeName<std::string> {
  static constexpr const char* kText = "text";
};
template <>
struct TypeName<std::vector<double>> {
  static constexpr const char* kText = "list of numbers";
};
template <>
struct TypeName<std::vector<std::int64_t>> {
  static constexpr const char* kText = "list of whole numbers";
};
template <>
struct TypeName<std::vector<std::string>> {
  static constexpr const char* kText = "list of words";
};

}  // namespace ini
}  // namespace hybrid
