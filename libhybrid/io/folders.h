// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

// Unlike their counterparts in the standard library, these functions do not terminate the program
// when memory is exhausted.

/// Whether a path exists, even as a dangling link.
bool name_exists(const std::filesystem::path& path);

/// An entry of a folder.
struct FolderEntry {
  std::string name;
  bool is_folder = false;  ///< false for a link to a folder
};

/// The entries of a folder, sorted by name. Throws SystemError that names it.
std::vector<FolderEntry> entries_of(const std::filesystem::path& folder);

/// All entries but folders in a folder and those below it, as paths relative to it, sorted. Throws
/// SystemError.
std::vector<std::string> files_below(const std::filesystem::path& folder);

/// Removes a folder with all that is in it, as far as that is possible.
void remove_tree(const std::filesystem::path& folder) noexcept;

/// Removes the folders from that of the file `name` up to, but without, `folder`, as far as they
/// are empty.
void remove_empty_folders(const std::filesystem::path& folder, const std::string& name) noexcept;

}  // namespace hybrid
