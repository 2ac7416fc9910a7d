// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

class Drawing;

/// A colour picture, rows from the top, three bytes (red, green, blue) per pixel.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
  /// The lines and texts of which the pixels were made, for formats that keep them; none of others.
  std::shared_ptr<const Drawing> drawing = nullptr;
};

/// Throws std::runtime_error where the picture has no pixels, or not as many as its size says.
void expect_pixels(const Image& image);

enum class PictureFormat { kPng, kSvg, kPdf };

/// The format of a name: png, svg or pdf. Throws Error for others.
PictureFormat picture_format(const std::string& name);
/// The end of the name of such a file, as ".png".
std::string ending(PictureFormat format);

/// The picture as the bytes of a file. As SVG and PDF, what was drawn stays lines and texts; pixels
/// are in it as they are, at two for a unit of length where they were pasted. Throws
/// std::runtime_error if it cannot be encoded.
std::string encoded(const Image& image, PictureFormat format);
/// The same of PNG.
std::string png(const Image& image);

}  // namespace hybrid
