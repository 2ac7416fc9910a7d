// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/sha256.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nettle/sha2.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <vector>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

constexpr std::size_t kBufferBytes = 1U << 18;

/// A file open for reading.
class OpenFile {
 public:
  explicit OpenFile(const std::filesystem::path& path)
      : path_(path), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (file_ < 0) fail();
    ::posix_fadvise(file_, 0, 0, POSIX_FADV_SEQUENTIAL);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() { ::close(file_); }

  /// Bytes read; 0 at the end.
  std::size_t read(char* to, std::size_t most) const {
    for (;;) {
      const ssize_t count = ::read(file_, to, most);
      if (count >= 0) return static_cast<std::size_t>(count);
      if (errno != EINTR) fail();
    }
  }

 private:
  [[noreturn]] void fail() const { throw SystemError(path_.string() + ": cannot be read", errno); }

  std::filesystem::path path_;
  int file_;
};

}  // namespace

std::string sha256_of(const std::function<std::size_t(char* to, std::size_t count)>& source) {
  sha256_ctx context{};
  sha256_init(&context);
  std::vector<unsigned char> buffer(kBufferBytes);
  for (std::size_t count = 0;
       (count = source(reinterpret_cast<char*>(buffer.data()), buffer.size())) > 0;) {
    sha256_update(&context, count, buffer.data());
  }
  std::array<unsigned char, SHA256_DIGEST_SIZE> digest{};
  sha256_digest(&context, digest.size(), digest.data());
  return fmt::format("{:02x}", fmt::join(digest, ""));
}

std::string sha256_of_file(const std::filesystem::path& path) {
  const OpenFile file(path);
  return sha256_of([&](char* to, std::size_t count) { return file.read(to, count); });
}

}  // namespace hybrid
