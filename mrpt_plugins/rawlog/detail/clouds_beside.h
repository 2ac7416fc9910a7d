// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/rawlog/log_object.h"

namespace hybrid {

/// Reads the points of clouds that are in files beside the log F.rawlog: those of its folder
/// F_Images, or else Images, of at most 1 GiB (bridge/log_files.h, named_file()). KITTI's form,
/// text, and what MRPT writes of depth cameras, of at most ten million points, are read here; maps
/// that MRPT serialised in the process that parses logs. Where a file is not there or damaged, the
/// cloud has none, and its fault is the reason.
void read_clouds_beside(LogObject& object, const std::string& rawlog);

}  // namespace hybrid
