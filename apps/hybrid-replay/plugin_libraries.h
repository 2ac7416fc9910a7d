// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

namespace hybrid {

/// Loads libraries that register further plugins or observation classes. Throws Error that names
/// the library and why it cannot be loaded.
void load_plugin_libraries(const std::vector<std::string>& paths);

}  // namespace hybrid
