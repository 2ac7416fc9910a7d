// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A colour picture, rows from the top, three bytes (red, green, blue) per pixel.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

/// The picture as the bytes of a PNG file; throws std::runtime_error if it cannot be encoded.
std::string png(const Image& image);
/// The same of a JPEG file of a quality of 0 to 100.
std::string jpeg(const Image& image, int quality);

/// The picture made so small that it is at most `width` pixels wide, with its own proportions.
Image shrunk(const Image& image, int width);

}  // namespace hybrid
