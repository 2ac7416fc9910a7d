// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/import/log_writer.h"

namespace hybrid {

/// Adds a remark if the last line of a text file has no end, or that of some of the .txt files of a
/// folder. Where all of a folder have none, its writer makes none.
inline void note_ends(const std::string& path, LogWriter& log) {
  if (!std::filesystem::is_directory(path)) {
    log.note_end(path);
    return;
  }
  std::size_t count = 0;
  std::vector<std::string> without;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    if (entry.path().extension() != ".txt") continue;
    ++count;
    if (ends_in_line(entry.path().string())) without.push_back(entry.path().filename().string());
  }
  if (without.empty() || without.size() == count) return;
  log.note(
      fmt::format("{}: the last line of {} of {} files has no end, such as that of {}; are "
                  "they cut off?",
                  path, without.size(), count, *std::min_element(without.begin(), without.end())));
}

}  // namespace hybrid
