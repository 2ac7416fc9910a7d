// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/mrpt_image.h"

#include <array>
#include <stdexcept>
#include <string>

namespace hybrid {

Image image_of(const mrpt::img::CImage& image) {
  if (image.isEmpty() || image.getPixelDepth() != mrpt::img::PixelDepth::D8U) {
    throw std::runtime_error("an image without pixels of 8 bits per channel");
  }
  Image out{static_cast<int>(image.getWidth()), static_cast<int>(image.getHeight()), {}};
  const std::string order = image.getChannelsOrder();  // GRAY, BGR or RGB by the version of MRPT
  const bool is_color = image.isColor();
  const std::size_t channels = is_color ? order.size() : 1;
  std::array<std::size_t, 3> places{};
  if (is_color) places = {order.find('R'), order.find('G'), order.find('B')};
  out.rgb.reserve(static_cast<std::size_t>(out.width) * out.height * 3);
  for (int y = 0; y < out.height; ++y) {
    const auto* row = image.ptr<std::uint8_t>(0, y);
    for (int x = 0; x < out.width; ++x, row += channels) {
      for (const std::size_t place : places) out.rgb.push_back(row[place]);
    }
  }
  return out;
}

}  // namespace hybrid
