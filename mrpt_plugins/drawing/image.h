// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <string>
#include <string_view>
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

/// The picture in the bytes of a file, whose format they tell, as the camera has it: what the file
/// says of its orientation is not applied. Throws std::exception if they are none. Bytes of
/// somebody else's are decoded in a process of its own: rawlog/image_decoder.h.
Image decoded(std::string_view bytes);
/// Lets this process decode without further threads.
void prepare_decoding();

/// Lets lack of memory inside OpenCV be std::bad_alloc in this process, as everywhere else. For
/// programs: the handler is one for the process.
void expect_bad_alloc_of_opencv();

/// The picture made so small that it is at most `width` pixels wide, with its own proportions.
Image shrunk(const Image& image, int width);

}  // namespace hybrid
