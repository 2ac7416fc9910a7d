// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A file written from front to back through a buffer. All functions throw SystemError that names
/// the file and the reason, such as a full disk.
class FileWriter {
 public:
  /// Creates or empties the file `path`; messages name it `shown`.
  explicit FileWriter(const std::filesystem::path& path, const std::filesystem::path& shown = {});
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;
  /// Without close(), bytes in the buffer are lost.
  ~FileWriter();

  void write(std::string_view bytes);
  /// Writes the content of the buffer and closes the file.
  void close();

 private:
  void flush();
  [[noreturn]] void fail(int code) const;

  std::string shown_;
  std::string buffer_;
  int file_ = -1;
};

/// Writes all bytes to an open file. Returns 0, or a value of errno.
int write_all(int file, std::string_view bytes);

/// Waits until a file or folder is on the disk, as far as its file system can tell. Throws
/// SystemError that names it `shown`.
void sync_to_disk(const std::filesystem::path& path, const std::filesystem::path& shown = {});

}  // namespace hybrid
