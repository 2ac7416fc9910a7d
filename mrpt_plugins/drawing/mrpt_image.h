// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/img/CImage.h>

#include "libhybrid/export.h"
#include "mrpt_plugins/drawing/image.h"

namespace HYBRID_API hybrid {

/// The pixels of an image in colours or grey. Throws std::runtime_error for one without pixels or
/// of more than 8 bits per channel, and what MRPT throws.
Image image_of(const mrpt::img::CImage& image);

}  // namespace hybrid
