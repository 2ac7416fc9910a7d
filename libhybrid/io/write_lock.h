// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <filesystem>
#include <string>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// The right to write something, which one process has at a time: a locked file `lock` in a folder
/// made for it. It ends with the process, however that ends; what is then left of the folder is
/// for the next one to clear.
class WriteLock {
 public:
  /// Creates `folder` where it is absent; its parent must exist. Throws Error that names `what` and
  /// the process that has the lock, SystemError where it cannot be had for another reason.
  WriteLock(const std::filesystem::path& folder, const std::filesystem::path& what);
  WriteLock(const WriteLock&) = delete;
  WriteLock& operator=(const WriteLock&) = delete;
  /// Removes the lock, and the folder if nothing else is in it.
  ~WriteLock();

  /// Gives the lock up where the folder is no longer where it was; removes nothing.
  void abandon();

 private:
  bool is_there(int file) const;

  std::string folder_;
  std::string name_;  // of the file
  int file_ = -1;
};

}  // namespace hybrid
