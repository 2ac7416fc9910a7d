// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <filesystem>
#include <optional>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Puts the folder `fresh` in the place of `folder` in one atomic step, with the permissions of
/// that. Returns where the old one is now, a hidden name `.FOLDER.part-XXXXXX` beside it. Nothing,
/// and nothing has changed, where that is not possible: the file system cannot exchange names,
/// `folder` is a mount point or the current folder, belongs to somebody else, or stands in a
/// folder that must not be written. Throws SystemError where it could not be made durable; all is
/// then as before.
std::optional<std::filesystem::path> exchange_folders(const std::filesystem::path& fresh,
                                                      const std::filesystem::path& folder);

/// Removes what processes that died in or after such an exchange left beside `folder`. Call it
/// where no other process can be at it.
void remove_exchanged(const std::filesystem::path& folder);

}  // namespace hybrid
