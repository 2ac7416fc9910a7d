// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/drawing/detail/cairo.h"

namespace hybrid {

/// What was drawn on a sheet, before it becomes pixels.
class Drawing {
 public:
  Drawing(int width, int height);

  cairo_surface_t* surface() const { return surface_.get(); }

  Image pixels() const;
  /// The bytes of a file. The same drawing always gives the same bytes.
  std::string file(PictureFormat format) const;

 private:
  void paint_on(cairo_surface_t* target) const;

  int width_, height_;
  cairo::Surface surface_;  // a recording
};

}  // namespace hybrid
