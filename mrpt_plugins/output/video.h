// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <filesystem>
#include <functional>

#include "mrpt_plugins/drawing/image.h"

namespace HYBRID_API hybrid {

/// Writes pictures as an MPEG-4 film to the file `path`, whose name ends in .mp4, and makes sure
/// that all are in it. `picture` is called for 0 .. count-1. Throws Error where the pictures differ
/// in size, this machine has no encoder, or the file is not whole, as on a full disk.
void encode_video(const std::filesystem::path& path, int count,
                  const std::function<Image(int)>& picture, double pictures_per_second = 10);

}  // namespace hybrid
