// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mrpt_plugins/drawing/image.h"

namespace HYBRID_API hybrid {

/// The photograph in the bytes of a file, whose format they tell, as the camera has it: what the
/// file says of its orientation is not applied. Throws std::exception if they are none. Bytes of
/// somebody else's are decoded in a process of its own: rawlog/image_decoder.h.
Image decoded(std::string_view bytes);

/// A picture of distances along the axis of a camera: rows from the top, 16 bits a pixel.
struct DepthImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint16_t> depths;
};

/// The depth image in the bytes of a file, such as a PNG of one channel of 16 bits. Throws
/// std::exception if they are none.
DepthImage decoded_depths(std::string_view bytes);

/// Lets this process decode without further threads.
void prepare_decoding();

/// Lets lack of memory inside OpenCV be std::bad_alloc in this process, as everywhere else. For
/// programs: the handler is one for the process.
void expect_bad_alloc_of_opencv();

/// The photograph made so small that it is at most `width` pixels wide, with its own proportions.
Image shrunk(const Image& image, int width);

/// The bytes of a JPEG file of a quality of 0 to 100; throws std::runtime_error if it cannot be
/// encoded.
std::string jpeg(const Image& image, int quality);

}  // namespace hybrid
