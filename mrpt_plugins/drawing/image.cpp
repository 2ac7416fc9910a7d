// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/image.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace hybrid {
namespace {

constexpr int kCompression = 6;  // of 0 to 9: half the size of OpenCV's default, in tens of ms

}  // namespace

std::string png(const Image& image) {
  const auto expected = static_cast<std::size_t>(image.width) * image.height * 3;
  if (image.width <= 0 || image.height <= 0 || image.rgb.size() != expected) {
    throw std::runtime_error("a picture without pixels cannot be encoded");
  }
  const cv::Mat rgb(image.height, image.width, CV_8UC3,
                    const_cast<std::uint8_t*>(image.rgb.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", bgr, bytes, {cv::IMWRITE_PNG_COMPRESSION, kCompression}))
    throw std::runtime_error("cannot encode a PNG");
  return {bytes.begin(), bytes.end()};
}

}  // namespace hybrid
