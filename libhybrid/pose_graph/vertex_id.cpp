// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/pose_graph/vertex_id.h"

#include <cctype>
#include <charconv>

namespace hybrid {
namespace {

constexpr std::size_t kMostDigits = 17;  // of an index of 56 bits
/// Where the character of a Symbol is, and below it the label of a LabeledSymbol.
constexpr int kCharacter = 48, kLabel = 40;

bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

}  // namespace

std::string vertex_name(std::uint64_t index) {
  const std::uint64_t id = vertex_id(index);
  if (id == index) return std::to_string(id);
  std::string name;
  for (const int shift : {kCharacter, kLabel}) {
    const auto c = static_cast<unsigned char>(index >> shift & (shift == kLabel ? 0xff : 0x7f));
    if (c == 0) continue;
    if (std::isgraph(c) == 0) return std::to_string(id);
    name += static_cast<char>(c);
  }
  return name + std::to_string(index & ((std::uint64_t{1} << kLabel) - 1));
}

std::string with_vertex_names(const std::string& message) {
  std::string text;
  for (std::size_t i = 0; i < message.size(); ++i) {
    std::uint64_t index = 0;
    const char* const begin = message.data() + i + 1;
    const char* const end = message.data() + message.size();
    const bool in_word = i > 0 && std::isalnum(static_cast<unsigned char>(message[i - 1])) != 0;
    const bool is_key =
        !in_word && (message[i] == 'x' || message[i] == 'l') && begin != end && is_digit(*begin);
    const auto read = is_key ? std::from_chars(begin, end, index) : std::from_chars_result{};
    if (!is_key || read.ec != std::errc() || index <= static_cast<std::uint64_t>(kLargestPlainId) ||
        static_cast<std::size_t>(read.ptr - begin) > kMostDigits) {
      text += message[i];
      continue;
    }
    text += vertex_name(index);
    i += static_cast<std::size_t>(read.ptr - begin);
  }
  return text;
}

}  // namespace hybrid
