// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A scalar type of binary point clouds: bytes, and 'i' signed, 'u' unsigned, 'f' floating.
struct BinaryNumber {
  int bytes = 0;
  char kind = 0;
};

/// The value of a scalar of 1, 2, 4 or 8 bytes, floating ones of 4 or 8.
inline double value_of(const char* raw, BinaryNumber type, bool big_endian) {
  const auto bytes = static_cast<std::size_t>(type.bytes);
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    bits = (bits << 8) | static_cast<unsigned char>(raw[big_endian ? i : bytes - 1 - i]);
  }
  if (type.kind == 'f' && type.bytes == 8) {
    double value = 0;
    std::memcpy(&value, &bits, sizeof(value));
    return value;
  }
  if (type.kind == 'f') {
    const auto half = static_cast<std::uint32_t>(bits);
    float single = 0;
    std::memcpy(&single, &half, sizeof(single));
    return static_cast<double>(single);
  }
  const std::uint64_t sign = std::uint64_t{1} << (8 * type.bytes - 1);
  double value = static_cast<double>(bits);
  if (type.kind == 'i' && (bits & sign) != 0) value -= 2.0 * static_cast<double>(sign);
  return value;
}

}  // namespace hybrid
