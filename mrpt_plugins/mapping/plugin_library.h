// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Loads a library that registers classes of plugins (HYBRID_REGISTER_PLUGIN) or of observations.
/// Its version tag is read from the file, and a child process tries it first, so that neither one
/// for another version nor a faulty one has an effect on the program. Throws
/// Error "path: why" if it is no regular file or no library, lacks a symbol, was built for another
/// version, ends the process or throws while it is loaded, or registers nothing.
void load_plugin_library(const std::string& path);

}  // namespace hybrid
