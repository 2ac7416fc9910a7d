// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/gzip_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostBytes = 1U << 30;  // bytes per call of zlib

}  // namespace

GzipWriter::GzipWriter(const std::filesystem::path& path, int level,
                       const std::filesystem::path& shown)
    : shown_(shown.string()) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) error_ = errno;
  check();
  file_ = ::gzdopen(file, fmt::format("wb{}", level).c_str());
  if (file_ != nullptr) return;
  ::close(file);
  error_ = ENOMEM;
  check();
}

GzipWriter::~GzipWriter() {
  if (file_ != nullptr) ::gzclose_w(file_);
}

size_t GzipWriter::Write(const void* buffer, size_t count) {
  const char* bytes = static_cast<const char*>(buffer);
  for (size_t done = 0; done < count && error_ == 0;) {
    const auto part = static_cast<unsigned>(std::min(count - done, kMostBytes));
    errno = 0;
    const int written = ::gzwrite(file_, bytes + done, part);
    if (written <= 0) error_ = errno != 0 ? errno : EIO;
    if (written > 0) done += static_cast<size_t>(written);
  }
  position_ += count;
  return count;
}

void GzipWriter::check() const {
  if (error_ != 0) throw SystemError(fmt::format("cannot write '{}'", shown_), error_);
}

void GzipWriter::close() {
  errno = 0;
  const int code = ::gzclose_w(std::exchange(file_, nullptr));
  if (code != Z_OK && error_ == 0) error_ = errno != 0 ? errno : EIO;
  check();
}

size_t GzipWriter::Read(void*, size_t) {
  throw Error(fmt::format("{}: is open for writing only", shown_));
}

std::uint64_t GzipWriter::Seek(std::int64_t, TSeekOrigin) {
  throw Error(fmt::format("{}: is written from start to end", shown_));
}

std::uint64_t GzipWriter::getTotalBytesCount() const {
  return position_;
}

}  // namespace hybrid
