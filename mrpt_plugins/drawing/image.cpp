// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/image.h"

#include <stdexcept>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/drawing/canvas.h"
#include "mrpt_plugins/drawing/detail/drawing.h"

namespace hybrid {

void expect_pixels(const Image& image) {
  const auto expected = static_cast<std::size_t>(image.width) * image.height * 3;
  if (image.width <= 0 || image.height <= 0 || image.rgb.size() != expected) {
    throw std::runtime_error("a picture without pixels cannot be encoded");
  }
}

cairo::Surface cairo::surface_of(const Image& image) {
  expect_pixels(image);
  Surface out(cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height));
  check(cairo_surface_status(out.get()));
  unsigned char* data = cairo_image_surface_get_data(out.get());
  const int stride = cairo_image_surface_get_stride(out.get());
  const std::uint8_t* from = image.rgb.data();
  for (int y = 0; y < image.height; ++y) {
    auto* row = reinterpret_cast<std::uint32_t*>(data + std::ptrdiff_t{stride} * y);
    for (int x = 0; x < image.width; ++x, from += 3) {
      row[x] = std::uint32_t{from[0]} << 16U | std::uint32_t{from[1]} << 8U | from[2];
    }
  }
  cairo_surface_mark_dirty(out.get());
  return out;
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

std::string png(const Image& image) {
  std::string out;
  cairo::check(
      cairo_surface_write_to_png_stream(cairo::surface_of(image).get(), cairo::append, &out));
  return out;
}

std::string encoded(const Image& image, PictureFormat format) {
  if (format == PictureFormat::kPng) return png(image);
  if (image.drawing) return image.drawing->file(format);
  Canvas sheet(image.width / Canvas::kScale, image.height / Canvas::kScale);
  sheet.paste(image, Pixel::Zero());
  return encoded(sheet.image(), format);
}

}  // namespace hybrid
