// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/detail/lzf.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "libhybrid/io/binary_number.h"

namespace hybrid {
namespace {

constexpr std::size_t kLongestLiteral = 32;  // bytes; a control byte below it begins a literal
constexpr std::size_t kLongLength = 7;       // of a copy; another byte is added to it

/// So many bytes; fewer where the file ends.
std::string bytes_in(TextReader& data, std::size_t count) {
  constexpr std::size_t kStep = std::size_t{1} << 20;
  std::string out;
  while (out.size() < count) {
    const std::size_t had = out.size();
    out.resize(std::min(count, had + kStep));
    if (!data.read_bytes(&out[had], out.size() - had)) data.fail("the compressed data ends early");
  }
  return out;
}

/// Takes the next byte; false at the end.
bool take(std::string_view& packed, std::size_t& byte) {
  if (packed.empty()) return false;
  byte = static_cast<unsigned char>(packed.front());
  packed.remove_prefix(1);
  return true;
}

/// Unpacks a block, a literal or a copy of what has been unpacked; false where there is none.
bool unpack_block(std::string_view& packed, std::string& out) {
  std::size_t control = 0;
  if (!take(packed, control)) return false;
  if (control < kLongestLiteral) {
    if (packed.size() < control + 1) return false;
    out += packed.substr(0, control + 1);
    packed.remove_prefix(control + 1);
    return true;
  }
  std::size_t length = control >> 5U, more = 0, low = 0;
  if (length == kLongLength && !take(packed, more)) return false;
  if (!take(packed, low)) return false;
  length += more + 2;
  const std::size_t back = ((control & 31U) << 8U) + low + 1;
  if (back > out.size()) return false;
  for (std::size_t i = 0; i < length; ++i) out += out[out.size() - back];
  return true;
}

}  // namespace

std::string read_lzf(TextReader& data) {
  constexpr BinaryNumber kSize{4, 'u'};
  std::array<char, 8> head{};
  if (!data.read_bytes(head.data(), head.size())) data.fail("the compressed data is missing");
  const auto packed_size = static_cast<std::size_t>(value_of(head.data(), kSize, false));
  const auto size = static_cast<std::size_t>(value_of(head.data() + 4, kSize, false));
  const std::string packed = bytes_in(data, packed_size);
  std::string_view rest = packed;
  std::string out;
  while (out.size() <= size && !rest.empty()) {
    if (!unpack_block(rest, out)) data.fail("the compressed data is damaged");
  }
  if (out.size() != size) {
    data.fail("the compressed data is damaged: it does not have the size that it states");
  }
  return out;
}

}  // namespace hybrid
