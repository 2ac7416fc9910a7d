// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/escaped.h"

#include <cstddef>
#include <cstdint>

namespace hybrid {
namespace {

constexpr std::size_t kLongestText = 200;
constexpr std::size_t kLongestWord = 40;

/// Bytes of the printable character at the beginning of `text` (RFC 3629); 0 if there is none.
std::size_t printable_bytes(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(0) < 0x80) return byte(0) >= 0x20 && byte(0) != 0x7f ? 1 : 0;
  const std::size_t count = byte(0) >= 0xf0 ? 4 : byte(0) >= 0xe0 ? 3 : 2;
  if (byte(0) < 0xc2 || byte(0) > 0xf4 || text.size() < count) return 0;
  std::uint32_t code = byte(0) & (0xff >> (count + 1));
  for (std::size_t i = 1; i < count; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
    code = (code << 6) | (byte(i) & 0x3f);
  }
  constexpr std::uint32_t kLeast[] = {0xa0, 0x800, 0x10000};  // below: control or overlong
  const bool surrogate = code >= 0xd800 && code < 0xe000;
  // Marks that change the direction of text, and line separators, would rearrange a message.
  const bool rearranges = (code >= 0x200b && code <= 0x200f) ||
                          (code >= 0x2028 && code <= 0x202e) ||
                          (code >= 0x2060 && code <= 0x206f) || code == 0xfeff;
  return code < kLeast[count - 2] || code > 0x10ffff || surrogate || rearranges ? 0 : count;
}

std::string shortened(std::string_view text, std::size_t longest) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string out;
  for (std::size_t shown = 0; !text.empty(); ++shown) {
    if (shown == longest) return out + "...";
    const std::size_t count = printable_bytes(text);
    if (count > 0) {
      out += text.substr(0, count);
    } else {
      const auto byte = static_cast<unsigned char>(text[0]);
      out += {'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15]};
    }
    text.remove_prefix(count > 0 ? count : 1);
  }
  return out;
}

}  // namespace

std::string escaped(std::string_view text) {
  return shortened(text, kLongestText);
}

std::string in_quotes(std::string_view word) {
  return "'" + shortened(word, kLongestWord) + "'";
}

}  // namespace hybrid
