// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "mrpt_plugins/drawing/image.h"

namespace HYBRID_API hybrid {

/// Encodes pictures as an H.264 film, or as MPEG-4 part 2 if this machine has no such encoder, in
/// the file `path` (.mp4), and checks that the film is complete. `picture` is called for 0 ..
/// count-1. Throws Error if the pictures differ in size, no encoder is available, or the file is
/// incomplete, as on a full disk. Returns a warning if the film is not H.264, else "".
std::string encode_video(const std::filesystem::path& path, int count,
                         const std::function<Image(int)>& picture, double pictures_per_second = 10);

}  // namespace hybrid
