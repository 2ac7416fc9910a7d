// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A regular file, open for reading from its start. Opening never waits, as it would for the other
/// end of a pipe.
class RegularFile {
 public:
  /// Throws Error "path: why" if the file is missing, may not be read, or is a folder, a pipe, a
  /// device or a socket.
  explicit RegularFile(const std::string& path);
  RegularFile(const RegularFile&) = delete;
  RegularFile& operator=(const RegularFile&) = delete;
  ~RegularFile();

  const std::string& path() const { return path_; }
  /// Size in bytes by the file system, which may be 0 for a file of /proc.
  std::uint64_t size() const { return size_; }
  int descriptor() const { return descriptor_; }

  /// Reads up to `count` bytes; 0 at the end of the file. Throws Error if reading fails.
  std::size_t read(char* to, std::size_t count);

 private:
  std::string path_;
  std::uint64_t size_ = 0;
  int descriptor_ = -1;
};

/// Largest file that is read as text, enough for 20 million edges of a pose graph.
inline constexpr std::uint64_t kLargestText = std::uint64_t{4} << 30;

/// The bytes of a regular file. Throws Error as RegularFile, and for more than `most` bytes.
std::string read_file(const std::string& path, std::uint64_t most = kLargestText);

/// Whether the last line of a file has no line end, as in a file that was cut off. Throws Error as
/// RegularFile.
bool ends_in_line(const std::string& path);

/// Throws Error that names `path` and the limit if `bytes` are more than `most`.
void check_size(const std::string& path, std::uint64_t bytes, std::uint64_t most);

}  // namespace hybrid
