// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/photograph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace hybrid {
namespace {

/// The pixels of a picture, which stay its own.
cv::Mat pixels_of(const Image& image) {
  expect_pixels(image);
  return {image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.rgb.data())};
}

/// The pixels in the bytes of a file; throws std::exception if there are none.
cv::Mat pixels_in(std::string_view bytes, int flags) {
  if (bytes.empty() || bytes.size() > std::numeric_limits<int>::max()) {
    throw std::runtime_error("the bytes are no picture");
  }
  const cv::Mat file(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
  cv::Mat pixels = cv::imdecode(file, flags);
  if (pixels.empty()) throw std::runtime_error("the bytes are no picture");
  return pixels;
}

/// Called by OpenCV before it throws its own exception; another one takes its place.
int throw_bad_alloc(int status, const char*, const char*, const char*, int, void*) {
  if (status == cv::Error::StsNoMem) throw std::bad_alloc();
  return 0;
}

}  // namespace

void expect_bad_alloc_of_opencv() {
  cv::redirectError(throw_bad_alloc);
}

std::string jpeg(const Image& image, int quality) {
  cv::Mat bgr;
  cv::cvtColor(pixels_of(image), bgr, cv::COLOR_RGB2BGR);
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, quality})) {
    throw std::runtime_error("cannot encode a picture");
  }
  return {bytes.begin(), bytes.end()};
}

Image decoded(std::string_view bytes) {
  const cv::Mat bgr = pixels_in(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  Image out{bgr.cols, bgr.rows,
            std::vector<std::uint8_t>(static_cast<std::size_t>(bgr.cols) * bgr.rows * 3)};
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, out.rgb.data());
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return out;
}

DepthImage decoded_depths(std::string_view bytes) {
  const cv::Mat image = pixels_in(bytes, cv::IMREAD_UNCHANGED);
  if (image.type() != CV_16UC1) throw std::runtime_error("not one channel of 16 bits");
  DepthImage out{image.cols, image.rows, {}};
  for (int row = 0; row < image.rows; ++row) {
    const auto* begin = image.ptr<std::uint16_t>(row);
    out.depths.insert(out.depths.end(), begin, begin + image.cols);
  }
  return out;
}

void prepare_decoding() {
  cv::setNumThreads(1);
}

Image shrunk(const Image& image, int width) {
  if (image.width <= width) return image;
  const int height = std::max(
      1, static_cast<int>(std::lround(static_cast<double>(image.height) * width / image.width)));
  Image out{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * height * 3)};
  cv::Mat small(height, width, CV_8UC3, out.rgb.data());
  cv::resize(pixels_of(image), small, small.size(), 0, 0, cv::INTER_AREA);
  return out;
}

}  // namespace hybrid
