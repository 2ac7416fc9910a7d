// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/drawing/canvas.h"

namespace HYBRID_API hybrid {

/// The words of `text` in rows of at most `room` pixels; a longer word has a row of its own.
std::vector<std::string> wrapped(const std::string& text, const TextStyle& style, double room);

/// Draws a title and below it a subtitle, whose first row is centred at `at`, or 34 pixels lower
/// where there is a title. Neither is wider than `room`: both are drawn smaller where they are
/// longer, and a subtitle that four fifths of its size do not suffice for goes on in further rows.
/// Returns the height of all rows, 34 pixels for the first of the subtitle and 24 for others.
double draw_heading(Canvas& canvas, const Pixel& at, double room, const std::string& title,
                    const std::string& subtitle);

}  // namespace hybrid
