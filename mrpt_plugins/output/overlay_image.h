// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "libhybrid/geometry/points.h"
#include "libhybrid/geometry/se3.h"
#include "mrpt_plugins/drawing/image.h"

namespace HYBRID_API hybrid {

/// The content of a picture of a registration.
struct Overlay {
  std::string title;
  std::string note;  ///< one line below the title
  Points source, target;
  SE3 before, after;  ///< T_target_source
  std::string unit;   ///< of length, e.g. "m"
};

/// overlay.png: both clouds before and after the registration, seen along each axis of the target
/// (from above only if the target is flat). Large clouds are thinned, and the picture says so.
Image overlay_image(const Overlay& overlay);

}  // namespace hybrid
