// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/write_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/file_writer.h"

namespace hybrid {
namespace {

constexpr const char* kName = "lock";
constexpr int kAttempts = 1000;  // each fails only if another process ends at that moment

std::string content(int file) {
  std::array<char, 256> buffer{};
  const ssize_t count = ::pread(file, buffer.data(), buffer.size(), 0);
  return {buffer.data(), static_cast<std::size_t>(count < 0 ? 0 : count)};
}

}  // namespace

WriteLock::WriteLock(const std::filesystem::path& folder, const std::filesystem::path& what)
    : folder_(folder.string()), name_(folder_ + "/" + kName) {
  const std::string shown = "cannot write '" + what.string() + "'";
  const std::string self =
      std::string(program_invocation_short_name) + " (process " + std::to_string(::getpid()) + ")";
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (::mkdir(folder.c_str(), 0777) != 0 && errno != EEXIST) throw SystemError(shown, errno);
    const int at = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (at < 0 && errno == ENOENT) continue;
    if (at < 0) throw SystemError(shown + ": " + folder.string(), errno);
    const int file = ::openat(at, kName, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    int error = file < 0 ? errno : 0;
    if (file >= 0 && ::flock(file, LOCK_EX | LOCK_NB) != 0) error = errno;
    const bool current = file >= 0 && is_there(file);
    const std::string owner = error == EWOULDBLOCK ? content(file) : "";
    ::close(at);
    if (error == 0 && current) {
      file_ = file;
      // For the messages of other processes only, so that a failure to write does not matter.
      if (::ftruncate(file_, 0) == 0) write_all(file_, self);
      return;
    }
    if (file >= 0) ::close(file);
    if (error == EWOULDBLOCK && current) {
      throw Error(shown + ": " + (owner.empty() ? "another program" : owner) + " is writing it");
    }
    if (error != 0 && error != ENOENT && error != EWOULDBLOCK) {
      throw SystemError(shown + ": " + folder.string(), error);
    }
  }
  throw Error(shown + ": " + folder.string() + " comes and goes");
}

/// Whether the open file still has its name, which the last owner of the lock may have removed.
bool WriteLock::is_there(int file) const {
  struct stat open = {}, named = {};
  return ::fstat(file, &open) == 0 && ::lstat(name_.c_str(), &named) == 0 &&
         open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

WriteLock::~WriteLock() {
  if (file_ < 0) return;
  const bool ours = is_there(file_);
  if (ours) ::unlink(name_.c_str());
  abandon();
  if (ours) ::rmdir(folder_.c_str());
}

void WriteLock::abandon() {
  if (file_ >= 0) ::close(std::exchange(file_, -1));
}

}  // namespace hybrid
