// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hybrid {

/// A number of 32 bits, the largest byte first.
inline std::string big_endian(std::uint32_t number) {
  std::string out;
  for (const int shift : {24, 16, 8, 0}) out += static_cast<char>((number >> shift) & 255U);
  return out;
}

/// A part of a PNG file with its length and checksum.
inline std::string png_chunk(const std::string& type, const std::string& content) {
  std::uint32_t crc = ~0U;
  for (const char byte : type + content) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xedb88320U : 0U);
  }
  return big_endian(static_cast<std::uint32_t>(content.size())) + type + content + big_endian(~crc);
}

/// A PNG file of one channel of 16 bits, not compressed; at most 32,000 pixels.
inline std::string depth_png(int width, const std::vector<std::uint16_t>& depths) {
  const int height = static_cast<int>(depths.size()) / width;
  std::string raw;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (i % static_cast<std::size_t>(width) == 0) raw += '\0';  // no filter of this row
    raw += static_cast<char>(depths[i] >> 8);
    raw += static_cast<char>(depths[i] & 255);
  }
  std::uint32_t a = 1, b = 0;
  for (const char byte : raw) {
    a = (a + static_cast<unsigned char>(byte)) % 65521U;
    b = (b + a) % 65521U;
  }
  const auto size = static_cast<std::uint32_t>(raw.size());
  std::string zlib("\x78\x01\x01", 3);  // one block, stored
  for (const std::uint32_t part : {size, ~size}) {
    zlib += static_cast<char>(part & 255U);
    zlib += static_cast<char>((part >> 8U) & 255U);
  }
  zlib += raw + big_endian((b << 16U) | a);
  const std::string shape = big_endian(static_cast<std::uint32_t>(width)) +
                            big_endian(static_cast<std::uint32_t>(height)) +
                            std::string("\x10\0\0\0\0", 5);
  return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", shape) + png_chunk("IDAT", zlib) +
         png_chunk("IEND", "");
}

}  // namespace hybrid
