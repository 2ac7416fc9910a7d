// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/detail/file_kind.h"

#include <algorithm>
#include <utility>

namespace hybrid {
namespace {

constexpr std::pair<std::string_view, std::string_view> kMagic[] = {
    {"\x1f\x8b", "compressed with gzip: unpack it, or if it is a rawlog, use hybrid-replay"},
    {"\x28\xb5\x2f\xfd",
     "compressed with zstd: unpack it, or if it is a rawlog, use hybrid-replay"},
    {"\xfd"
     "7zXZ",
     "compressed with xz: unpack it"},
    {"BZh", "compressed with bzip2: unpack it"},
    {"PK\x03\x04", "a zip archive: unpack it"},
    {"\x89PNG", "a picture"},
    {"\xff\xd8\xff", "a picture"},
    {"%PDF-", "a PDF document"},
    {"\x7f"
     "ELF",
     "a program"},
};

/// MRPT's objects begin with the length of the name of their class, its highest bit set.
bool is_rawlog(std::string_view head) {
  if (head.empty() || (head[0] & 0x80) == 0) return false;
  const auto length = static_cast<std::size_t>(head[0] & 0x7f);
  constexpr std::size_t kLeast = 4;
  const std::string_view name = head.substr(1, length);
  const auto is_part = [](char c) {
    return c == ':' || c == '_' || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') ||
           (c >= 'a' && c <= 'z');
  };
  return length >= kLeast && name.size() == length &&
         std::all_of(name.begin(), name.end(), is_part);
}

}  // namespace

std::string_view binary_kind(std::string_view head) {
  for (const auto& [magic, kind] : kMagic) {
    if (head.substr(0, magic.size()) == magic) return kind;
  }
  return is_rawlog(head) ? "a rawlog: use hybrid-replay" : "";
}

}  // namespace hybrid
