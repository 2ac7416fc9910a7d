// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/file_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

constexpr std::size_t kBufferBytes = 1U << 16;

}  // namespace

int write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(file, bytes.data(), bytes.size());
    if (count < 0 && errno != EINTR) return errno;
    if (count == 0) return ENOSPC;
    if (count > 0) bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return 0;
}

FileWriter::FileWriter(const std::filesystem::path& path, const std::filesystem::path& shown)
    : shown_((shown.empty() ? path : shown).string()) {
  file_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) fail(errno);
}

FileWriter::~FileWriter() {
  if (file_ >= 0) ::close(file_);
}

void FileWriter::write(std::string_view bytes) {
  buffer_.append(bytes);
  if (buffer_.size() >= kBufferBytes) flush();
}

void FileWriter::flush() {
  if (const int error = write_all(file_, buffer_); error != 0) fail(error);
  buffer_.clear();
}

void FileWriter::close() {
  flush();
  if (::close(std::exchange(file_, -1)) != 0) fail(errno);
}

void FileWriter::fail(int code) const {
  throw SystemError("cannot write '" + shown_ + "'", code);
}

void sync_to_disk(const std::filesystem::path& path, const std::filesystem::path& shown) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  int error = file < 0 ? errno : 0;
  // EINVAL: the file system does not support it, as some network and user-space file systems.
  if (file >= 0 && ::fsync(file) != 0 && errno != EINVAL) error = errno;
  if (file >= 0) ::close(file);
  if (error != 0) {
    throw SystemError("cannot write '" + (shown.empty() ? path : shown).string() + "'", error);
  }
}

}  // namespace hybrid
