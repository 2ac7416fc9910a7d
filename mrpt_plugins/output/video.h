// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "mrpt_plugins/drawing/image.h"

namespace HYBRID_API hybrid {

/// Writes pictures as an H.264 film, or where this machine has no such encoder MPEG-4 part 2, to
/// the file `path`, whose name ends in .mp4, and makes sure that all are in it. `picture` is called
/// for 0 .. count-1. Throws Error where the pictures differ in size, this machine has no encoder,
/// or the file is not whole, as on a full disk. Returns a warning where the film is not H.264, else
/// "".
std::string encode_video(const std::filesystem::path& path, int count,
                         const std::function<Image(int)>& picture, double pictures_per_second = 10);

}  // namespace hybrid
