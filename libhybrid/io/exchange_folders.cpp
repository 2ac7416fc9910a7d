// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/exchange_folders.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/io/file_writer.h"
#include "libhybrid/io/folders.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kRandomLetters = 6;  // of mkdtemp

std::string hidden_prefix(const fs::path& folder) {
  return "." + folder.filename().string() + ".part-";
}

bool swap_names(const fs::path& a, const fs::path& b) {
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
}

/// Gives `fresh` the permissions of `folder`; false if that fails or their owners differ.
bool make_alike(const fs::path& fresh, const fs::path& folder) {
  struct stat a = {}, b = {};
  if (::stat(fresh.c_str(), &a) != 0 || ::stat(folder.c_str(), &b) != 0) return false;
  return a.st_uid == b.st_uid && a.st_gid == b.st_gid &&
         ::chmod(fresh.c_str(), b.st_mode & 07777U) == 0;
}

}  // namespace

std::optional<fs::path> exchange_folders(const fs::path& fresh, const fs::path& given) {
  std::error_code error;
  const fs::path folder = fs::canonical(given, error);
  if (error || !folder.has_filename() || fs::equivalent(folder, fs::current_path(), error) ||
      !make_alike(fresh, folder)) {
    return std::nullopt;
  }
  std::string name =
      (folder.parent_path() / (hidden_prefix(folder) + std::string(kRandomLetters, 'X'))).string();
  if (::mkdtemp(name.data()) == nullptr) return std::nullopt;
  // Returned as it is: a copy behind the exchange could fail for want of memory.
  std::optional<fs::path> place(name);
  if (std::rename(fresh.c_str(), place->c_str()) != 0) {
    ::rmdir(place->c_str());
    return std::nullopt;
  }
  const auto back = [&] {
    if (std::rename(place->c_str(), fresh.c_str()) == 0) return;
    throw SystemError("cannot write '" + given.string() + "'", errno);
  };
  if (!swap_names(*place, folder)) {
    back();
    return std::nullopt;
  }
  try {
    sync_to_disk(folder.parent_path(), given);
  } catch (...) {
    if (swap_names(*place, folder)) back();
    throw;
  }
  return place;
}

void remove_exchanged(const fs::path& given) {
  std::error_code error;
  const fs::path folder = fs::canonical(given, error);
  if (error || !folder.has_filename()) return;
  const std::string prefix = hidden_prefix(folder);
  for (const FolderEntry& entry : entries_of(folder.parent_path())) {
    if (entry.is_folder && entry.name.size() == prefix.size() + kRandomLetters &&
        entry.name.rfind(prefix, 0) == 0) {
      remove_tree(folder.parent_path() / entry.name);
    }
  }
}

}  // namespace hybrid
