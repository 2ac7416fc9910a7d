// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/detail/drawing.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>

#include <cstdint>
#include <map>
#include <regex>

namespace hybrid {
namespace {

/// Cairo numbers the parts of an SVG in the order of the whole process; here it is that of the
/// file.
std::string renumbered(const std::string& svg) {
  static const std::regex kName(R"((id="|#)([a-z]+)(\d+)(["\)-]))");
  std::map<std::string, std::size_t> numbers;
  std::string out;
  auto at = svg.begin();
  for (std::sregex_iterator i(svg.begin(), svg.end(), kName), end; i != end; ++i) {
    const std::smatch& match = *i;
    const std::size_t number =
        numbers.try_emplace(match[2].str() + match[3].str(), numbers.size()).first->second;
    out.append(at, match[0].first);
    out += match[1].str() + match[2].str() + std::to_string(number) + match[4].str();
    at = match[0].second;
  }
  return out.append(at, svg.end());
}

}  // namespace

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

Drawing::Drawing(int width, int height) : width_(width), height_(height) {
  const cairo_rectangle_t extent{0, 0, static_cast<double>(width), static_cast<double>(height)};
  surface_.reset(cairo_recording_surface_create(CAIRO_CONTENT_COLOR_ALPHA, &extent));
  cairo::check(cairo_surface_status(surface()));
}

void Drawing::paint_on(cairo_surface_t* target) const {
  const cairo::Context context(cairo_create(target));
  cairo_set_source_rgb(context.get(), 1, 1, 1);
  cairo_paint(context.get());
  cairo_set_source_surface(context.get(), surface(), 0, 0);
  cairo_paint(context.get());
  cairo::check(cairo_status(context.get()));
}

Image Drawing::pixels() const {
  const cairo::Surface sheet(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width_, height_));
  cairo::check(cairo_surface_status(sheet.get()));
  paint_on(sheet.get());
  cairo_surface_flush(sheet.get());
  const unsigned char* data = cairo_image_surface_get_data(sheet.get());
  const int stride = cairo_image_surface_get_stride(sheet.get());
  Image out{width_, height_, {}};
  out.rgb.reserve(static_cast<std::size_t>(width_) * height_ * 3);
  for (int y = 0; y < height_; ++y) {
    const auto* row = reinterpret_cast<const std::uint32_t*>(data + std::ptrdiff_t{stride} * y);
    for (int x = 0; x < width_; ++x) {
      for (const unsigned shift : {16U, 8U, 0U}) {
        out.rgb.push_back(static_cast<std::uint8_t>(row[x] >> shift));
      }
    }
  }
  return out;
}

std::string Drawing::file(PictureFormat format) const {
  std::string out;
  const bool is_pdf = format == PictureFormat::kPdf;
  const auto create =
      is_pdf ? cairo_pdf_surface_create_for_stream : cairo_svg_surface_create_for_stream;
  const cairo::Surface target(create(cairo::append, &out, width_, height_));
  cairo::check(cairo_surface_status(target.get()));
  // No time of its making is in the file.
  if (is_pdf) cairo_pdf_surface_set_metadata(target.get(), CAIRO_PDF_METADATA_CREATE_DATE, "");
  paint_on(target.get());
  cairo_surface_finish(target.get());
  cairo::check(cairo_surface_status(target.get()));
  return is_pdf ? out : renumbered(out);
}

}  // namespace hybrid
