// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/io/CStream.h>

#include <filesystem>
#include <string>

#include "libhybrid/export.h"

struct gzFile_s;  // zlib's file handle

namespace HYBRID_API hybrid {

/// A compressed file as an MRPT stream. Write errors are kept until check() or close(), because
/// MRPT would wrap an exception into a report of its own.
class GzipWriter : public mrpt::io::CStream {
 public:
  /// Creates or empties the file `path`; messages name it `shown`. `level` is zlib's, 1 to 9.
  /// Throws SystemError.
  GzipWriter(const std::filesystem::path& path, int level, const std::filesystem::path& shown);
  GzipWriter(const GzipWriter&) = delete;
  GzipWriter& operator=(const GzipWriter&) = delete;
  /// Without close(), buffered data is lost.
  ~GzipWriter() override;

  size_t Write(const void* buffer, size_t count) override;
  std::uint64_t getPosition() const override { return position_; }
  std::string getStreamDescription() const override { return shown_; }

  /// Throws SystemError that names the file and the reason if something could not be written.
  void check() const;
  /// Flushes and closes the file; throws as check() does.
  void close();

  /// Unsupported: these throw Error.
  size_t Read(void* buffer, size_t count) override;
  std::uint64_t Seek(std::int64_t offset, TSeekOrigin origin) override;
  std::uint64_t getTotalBytesCount() const override;

 private:
  std::string shown_;
  gzFile_s* file_ = nullptr;
  std::uint64_t position_ = 0;
  int error_ = 0;  // a value of errno
};

}  // namespace hybrid
