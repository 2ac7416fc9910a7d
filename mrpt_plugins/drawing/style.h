// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A colour, 0 to 255 each.
struct Color {
  std::uint8_t red = 0, green = 0, blue = 0;
};

enum class Marker { kNone, kCircle, kSquare, kTriangle, kDiamond, kPentagon, kStar, kPlus, kCross };

enum class LineStyle { kNone, kSolid, kDashed, kDotted };

/// Colours that people with any of the common colour deficiencies can tell apart (after Okabe and
/// Ito). A thing has the same colour in every picture.
namespace palette {
constexpr Color kBlack{0, 0, 0};
constexpr Color kWhite{255, 255, 255};
constexpr Color kInk{40, 40, 40};            ///< text and frames
constexpr Color kMuted{90, 90, 90};          ///< subtitles and notes
constexpr Color kFaint{225, 225, 225};       ///< grid lines
constexpr Color kEstimate{0, 114, 178};      ///< estimate of the solver (blue)
constexpr Color kDeadReckoning{213, 94, 0};  ///< dead reckoning (vermilion)
constexpr Color kTruth{170, 170, 170};       ///< ground truth (grey)
constexpr Color kUnclassed{0, 158, 115};     ///< landmarks without a class (green)
}  // namespace palette

/// Colour of the i-th series or class; repeats after six.
Color series_color(std::size_t i);

/// Shape of the i-th class; shape and colour together are unique for 36 classes.
Marker class_marker(std::size_t i);

}  // namespace hybrid
