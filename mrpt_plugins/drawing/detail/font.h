// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cairo.h>

#include <string>

namespace hybrid {

/// The font of pictures: DejaVu Sans, or what this machine has in its place; for characters that it
/// lacks, the first other font that has them. Characters stand one after the other in the order of
/// the text, which does not suit scripts that join letters. Bytes that are no UTF-8 are drawn as
/// U+FFFD. `capitals` is the height of capital letters.
namespace font {

double width(const std::string& text, double capitals, bool bold);

/// Draws at the current point, which is on the base line.
void draw(cairo_t* context, const std::string& text, double capitals, bool bold);

/// Adds the outline of the text at the current point to the path.
void add_outline(cairo_t* context, const std::string& text, double capitals, bool bold);

}  // namespace font
}  // namespace hybrid
