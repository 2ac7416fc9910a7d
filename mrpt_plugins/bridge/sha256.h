// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <filesystem>
#include <string>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// SHA-256 of a file (FIPS 180-4), 64 lower-case hexadecimal digits. Throws SystemError that names
/// the file if it cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace hybrid
