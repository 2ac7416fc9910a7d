// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/io/CStream.h>

#include <cstdint>
#include <memory>
#include <string>

struct gzFile_s;  // zlib's file handle

namespace hybrid {

/// What a pass over a whole file found. A plain file counts as sound: it carries no checksum.
struct GzipCheck {
  enum class State { kSound, kTruncated, kDamaged };
  State state = State::kSound;
  bool is_gzip = false;
  std::uint64_t bytes = 0;  ///< Uncompressed, up to the first fault.
  std::string message;      ///< Empty if sound.
};

/// Decompresses `path` to its end and compares checksums; throws Error if it cannot be opened.
GzipCheck check_gzip(const std::string& path);

/// Reads a gzip or plain file as an MRPT stream that knows its place in the uncompressed bytes.
class GzipStream : public mrpt::io::CStream {
 public:
  /// Throws Error if the file is missing or cannot be opened.
  explicit GzipStream(const std::string& path);

  size_t Read(void* buffer, size_t count) override;
  std::uint64_t getPosition() const override { return position_; }
  /// Place in the file as it is on disk, for progress displays.
  std::uint64_t compressed_position() const;
  bool hit_end() const { return hit_end_; }
  std::string getStreamDescription() const override { return path_; }

  /// Unsupported: these throw Error.
  size_t Write(const void* buffer, size_t count) override;
  std::uint64_t Seek(std::int64_t offset, TSeekOrigin origin) override;
  std::uint64_t getTotalBytesCount() const override;

 private:
  struct Close {
    void operator()(gzFile_s* file) const;
  };
  std::string path_;
  std::unique_ptr<gzFile_s, Close> file_;
  std::uint64_t position_ = 0;
  bool hit_end_ = false;
};

}  // namespace hybrid
