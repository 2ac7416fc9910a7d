// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// SHA-256 of a file (FIPS 180-4), 64 lower-case hexadecimal digits. Throws SystemError that names
/// the file if it cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

/// The same of what a source puts at `to`, up to `count` bytes a call, 0 at its end.
std::string sha256_of(const std::function<std::size_t(char* to, std::size_t count)>& source);

}  // namespace hybrid
