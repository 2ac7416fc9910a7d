// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <filesystem>
#include <string>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// An exclusive lock for writing: a locked file `lock` in a folder made for it. It ends with the
/// process, however that ends; the next process clears what is left of the folder then.
class WriteLock {
 public:
  /// Creates `folder` if it is absent; its parent must exist. Throws Error that names `what` and
  /// the process that has the lock, SystemError if the lock cannot be taken for another reason.
  WriteLock(const std::filesystem::path& folder, const std::filesystem::path& what);
  WriteLock(const WriteLock&) = delete;
  WriteLock& operator=(const WriteLock&) = delete;
  /// Removes the lock, and the folder if nothing else is in it.
  ~WriteLock();

  /// Releases the lock without removing anything, for a folder that has moved.
  void abandon();

 private:
  bool is_there(int file) const;

  std::string folder_;
  std::string name_;  // of the locked file
  int file_ = -1;
};

}  // namespace hybrid
