// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/gzip_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

constexpr unsigned kBufferBytes = 1U << 17;

gzFile open_for_reading(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) throw Error(fmt::format("{}: no such file", path));
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw Error(fmt::format("{}: is not a file", path));
  }
  const gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) {
    throw Error(fmt::format("{}: cannot be opened: {}", path, std::strerror(errno)));
  }
  gzbuffer(file, kBufferBytes);
  return file;
}

}  // namespace

GzipCheck check_gzip(const std::string& path) {
  const gzFile file = open_for_reading(path);
  GzipCheck check;
  std::vector<char> buffer(kBufferBytes);
  int got = 0;
  while ((got = gzread(file, buffer.data(), kBufferBytes)) > 0) {
    check.bytes += static_cast<std::uint64_t>(got);
  }
  check.is_gzip = gzdirect(file) == 0;
  int code = Z_OK;
  const char* text = gzerror(file, &code);
  if (code == Z_BUF_ERROR) {
    check.state = GzipCheck::State::kTruncated;
    check.message = "the compressed file ends early";
  } else if (code != Z_OK && code != Z_STREAM_END) {
    check.state = GzipCheck::State::kDamaged;
    check.message = fmt::format("the compressed file is damaged: {}", text);
  }
  gzclose_r(file);
  return check;
}

void GzipStream::Close::operator()(gzFile_s* file) const {
  gzclose_r(file);
}

GzipStream::GzipStream(const std::string& path) : path_(path), file_(open_for_reading(path)) {}

size_t GzipStream::Read(void* buffer, size_t count) {
  size_t done = 0;
  while (done < count) {
    const auto want = static_cast<unsigned>(std::min<size_t>(count - done, 1U << 30));
    const int got = gzread(file_.get(), static_cast<char*>(buffer) + done, want);
    if (got <= 0) {
      hit_end_ = true;
      break;
    }
    done += static_cast<size_t>(got);
  }
  position_ += done;
  return done;
}

std::uint64_t GzipStream::compressed_position() const {
  return static_cast<std::uint64_t>(std::max<z_off_t>(0, gzoffset(file_.get())));
}

size_t GzipStream::Write(const void*, size_t) {
  throw Error(fmt::format("{}: is open for reading only", path_));
}

std::uint64_t GzipStream::Seek(std::int64_t, TSeekOrigin) {
  throw Error(fmt::format("{}: is read from start to end", path_));
}

std::uint64_t GzipStream::getTotalBytesCount() const {
  throw Error(fmt::format("{}: the uncompressed size is not known beforehand", path_));
}

}  // namespace hybrid
