// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/image_decoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/depth_png.h"

namespace hybrid {
namespace {

/// Columns of red that grow darker downwards.
Image red(int width, int height) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.rgb.push_back(static_cast<std::uint8_t>(200 - y));
      image.rgb.push_back(10);
      image.rgb.push_back(20);
    }
  }
  return image;
}

TEST(ImageDecoder, MakesSmallPicturesOneAfterTheOther) {
  ImageDecoder decoder(40);
  for (const int width : {20, 40, 160}) {
    const auto small = decoder.decode(png(red(width, 60)));
    ASSERT_TRUE(small) << width;
    EXPECT_EQ(small->width, std::min(width, 40));
    EXPECT_EQ(small->height, width > 40 ? 15 : 60);
    EXPECT_NEAR(small->rgb[0], 200, 3);
    EXPECT_EQ(small->rgb[1], 10);
    EXPECT_EQ(small->rgb[2], 20);
  }
}

TEST(ImageDecoder, WhatIsNoPictureEndsNothing) {
  ImageDecoder decoder(40);
  const std::string whole = png(red(30, 30));
  std::string damaged = whole;
  for (std::size_t i = 60; i < damaged.size(); i += 3) damaged[i] = static_cast<char>(i);
  for (const std::string& bytes : {std::string(1, '\0'), std::string(5000, 'x'),
                                   whole.substr(0, 40), damaged, std::string()}) {
    decoder.decode(bytes);
    const auto after = decoder.decode(whole);
    ASSERT_TRUE(after);
    EXPECT_EQ(after->width, 30);
  }
  EXPECT_FALSE(decoder.decode(std::string(5000, 'x')));
}

TEST(DepthDecoder, KeepsAllBits) {
  DepthDecoder decoder;
  const std::vector<std::uint16_t> depths{0, 1, 255, 256, 65535, 1000};
  const std::string whole = depth_png(3, depths);
  for (const std::string& bytes : {whole, whole.substr(0, 50), png(red(30, 30)), whole}) {
    const auto image = decoder.decode(bytes);
    ASSERT_EQ(image.has_value(), bytes == whole);
    if (!image) continue;
    EXPECT_EQ(image->width, 3);
    EXPECT_EQ(image->height, 2);
    EXPECT_EQ(image->depths, depths);
  }
}

}  // namespace
}  // namespace hybrid
