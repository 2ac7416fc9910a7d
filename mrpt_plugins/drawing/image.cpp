// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/image.h"

#include <stdexcept>

#include "libhybrid/core/error.h"

namespace hybrid {

void expect_pixels(const Image& image) {
  const auto expected = static_cast<std::size_t>(image.width) * image.height * 3;
  if (image.width <= 0 || image.height <= 0 || image.rgb.size() != expected) {
    throw std::runtime_error("a picture without pixels cannot be encoded");
  }
}

PictureFormat picture_format(const std::string& name) {
  if (name == "png") return PictureFormat::kPng;
  if (name == "svg") return PictureFormat::kSvg;
  if (name == "pdf") return PictureFormat::kPdf;
  throw Error("there is no format '" + name + "' of pictures: png, svg or pdf");
}

std::string ending(PictureFormat format) {
  switch (format) {
    case PictureFormat::kSvg:
      return ".svg";
    case PictureFormat::kPdf:
      return ".pdf";
    case PictureFormat::kPng:
      break;
  }
  return ".png";
}

}  // namespace hybrid
