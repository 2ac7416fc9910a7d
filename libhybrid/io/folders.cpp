// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/folders.h"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

bool is_folder(const fs::path& path) {
  struct stat found = {};
  return ::lstat(path.c_str(), &found) == 0 && S_ISDIR(found.st_mode);
}

void add_files(const fs::path& folder, const std::string& below, std::vector<std::string>& names) {
  for (const FolderEntry& entry : entries_of(folder)) {
    if (entry.is_folder) {
      add_files(folder / entry.name, below + entry.name + "/", names);
    } else {
      names.push_back(below + entry.name);
    }
  }
}

void remove_below(const fs::path& folder) {
  for (const FolderEntry& entry : entries_of(folder)) {
    const fs::path path = folder / entry.name;
    if (entry.is_folder) {
      remove_below(path);
    } else {
      ::unlink(path.c_str());
    }
  }
  ::rmdir(folder.c_str());
}

}  // namespace

bool name_exists(const fs::path& path) {
  struct stat found = {};
  return ::lstat(path.c_str(), &found) == 0;
}

std::vector<FolderEntry> entries_of(const fs::path& folder) {
  const std::unique_ptr<DIR, int (*)(DIR*)> open(::opendir(folder.c_str()), ::closedir);
  if (open == nullptr) throw SystemError("cannot read the folder '" + folder.string() + "'", errno);
  std::vector<FolderEntry> entries;
  errno = 0;
  while (const dirent* entry = ::readdir(open.get())) {
    const std::string name = entry->d_name;
    if (name == "." || name == "..") continue;
    const bool unknown = entry->d_type == DT_UNKNOWN;
    entries.push_back({name, unknown ? is_folder(folder / name) : entry->d_type == DT_DIR});
    errno = 0;
  }
  if (errno != 0) throw SystemError("cannot read the folder '" + folder.string() + "'", errno);
  std::sort(entries.begin(), entries.end(),
            [](const FolderEntry& a, const FolderEntry& b) { return a.name < b.name; });
  return entries;
}

std::vector<std::string> files_below(const fs::path& folder) {
  std::vector<std::string> names;
  add_files(folder, "", names);
  std::sort(names.begin(), names.end());
  return names;
}

void remove_tree(const fs::path& folder) noexcept {
  try {
    if (is_folder(folder)) remove_below(folder);
  } catch (...) {  // what could not be listed stays
  }
}

void remove_empty_folders(const fs::path& folder, const std::string& name) noexcept {
  try {
    for (std::size_t slash = name.rfind('/'); slash != std::string::npos && slash > 0;
         slash = name.rfind('/', slash - 1)) {
      ::rmdir((folder / name.substr(0, slash)).c_str());
    }
  } catch (...) {  // an empty folder stays
  }
}

}  // namespace hybrid
