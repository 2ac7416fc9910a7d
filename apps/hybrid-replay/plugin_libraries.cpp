// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-replay/plugin_libraries.h"

#include <fmt/format.h>
#include <mrpt/system/os.h>

#include <filesystem>

#include "libhybrid/core/error.h"

namespace hybrid {

void load_plugin_libraries(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    // With a slash, so that the loader takes the file and does not search the system's folders.
    const std::string absolute = std::filesystem::absolute(path).string();
    std::string why;
    if (!std::filesystem::exists(absolute)) throw Error(fmt::format("-p {}: no such file", path));
    if (!mrpt::system::loadPluginModule(absolute, why)) {
      const std::size_t last = why.find_last_not_of(" \n");
      why.erase(last == std::string::npos ? 0 : last + 1);
      why.erase(0, why.rfind('\n') + 1);
      throw Error(fmt::format("-p {}: cannot be loaded: {}", path, why));
    }
  }
}

}  // namespace hybrid
