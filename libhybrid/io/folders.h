// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

// Unlike those of the standard library here, these may run out of memory without ending the
// program.

/// Whether something has that name, be it a link to nowhere.
bool name_exists(const std::filesystem::path& path);

/// What is in a folder.
struct FolderEntry {
  std::string name;
  bool is_folder = false;  ///< itself, not by a link
};

/// The entries of a folder, sorted by name. Throws SystemError that names it.
std::vector<FolderEntry> entries_of(const std::filesystem::path& folder);

/// All that is no folder in a folder and those below, as paths relative to it, sorted. Throws
/// SystemError.
std::vector<std::string> files_below(const std::filesystem::path& folder);

/// Removes a folder with all that is in it, as far as that is possible.
void remove_tree(const std::filesystem::path& folder) noexcept;

/// Removes the folders from that of the file `name` up to, but without, `folder`, as far as they
/// are empty.
void remove_empty_folders(const std::filesystem::path& folder, const std::string& name) noexcept;

}  // namespace hybrid
