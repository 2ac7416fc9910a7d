// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <filesystem>
#include <optional>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Replaces `folder` by the folder `fresh` in one atomic step, with the permissions of `folder`.
/// Returns the path of the old folder, a hidden name `.FOLDER.part-RANDOM` beside it. Empty, with
/// nothing changed, if that is not possible: the file system cannot exchange names, `folder` is a
/// mount point or the current folder, it has another owner, or its parent must not be written.
/// Throws SystemError, with nothing changed, if the exchange cannot be made durable.
std::optional<std::filesystem::path> exchange_folders(const std::filesystem::path& fresh,
                                                      const std::filesystem::path& folder);

/// Removes the folders that processes which died in or after such an exchange left beside `folder`.
/// No other process may be exchanging it at the time.
void remove_exchanged(const std::filesystem::path& folder);

}  // namespace hybrid
