// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <filesystem>
#include <functional>

#include "mrpt_plugins/output/image.h"

namespace hybrid {

/// Writes pictures as an MPEG-4 film (.mp4). Throws Error that names the file where the name ends
/// otherwise, the folder is missing, the pictures differ in size, or this machine has no encoder.
/// `picture` is called for 0 .. count-1.
void save_video(const std::filesystem::path& path, int count,
                const std::function<Image(int)>& picture, double pictures_per_second = 10);

/// Throws as save_video would, without leaving a file: to be asked before long work.
void check_video(const std::filesystem::path& path);

}  // namespace hybrid
