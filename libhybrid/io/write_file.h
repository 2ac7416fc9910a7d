// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <string_view>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Writes a file, which appears when it is complete and on the disk. Throws Error that names the
/// path if that fails; an older file of that name then stays unchanged.
void write_file(const std::string& path, std::string_view content);

}  // namespace hybrid
