// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

std::string reason(int error) {
  if (error == ENOENT || error == ENOTDIR) return "no such file";
  if (error == ENXIO) return "is a socket, not a regular file";
  return std::string("cannot be read: ") + std::strerror(error);
}

/// The kind of a file that is not a regular one, or nullptr.
const char* other_kind(mode_t mode) {
  if (S_ISREG(mode)) return nullptr;
  if (S_ISDIR(mode)) return "is a folder, not a file";
  if (S_ISFIFO(mode)) return "is a pipe, not a regular file";
  return "is a device, not a regular file";
}

/// "3 GiB", in the largest unit in which it is a whole number.
std::string size_text(std::uint64_t bytes) {
  const char* const units[] = {" bytes", " KiB", " MiB", " GiB"};
  std::size_t unit = 0;
  for (; unit < 3 && bytes >= 1024 && bytes % 1024 == 0; ++unit) bytes /= 1024;
  return std::to_string(bytes) + units[unit];
}

}  // namespace

RegularFile::RegularFile(const std::string& path) : path_(path) {
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (descriptor_ < 0) throw Error(path + ": " + reason(errno));
  struct stat status {};
  const char* kind = nullptr;
  if (::fstat(descriptor_, &status) != 0 || (kind = other_kind(status.st_mode)) != nullptr) {
    const std::string why = kind != nullptr ? kind : reason(errno);
    ::close(descriptor_);
    throw Error(path + ": " + why);
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

RegularFile::~RegularFile() {
  ::close(descriptor_);
}

std::size_t RegularFile::read(char* to, std::size_t count) {
  while (true) {
    const ssize_t got = ::read(descriptor_, to, count);
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR) throw Error(path_ + ": " + reason(errno));
  }
}

std::string read_file(const std::string& path, std::uint64_t most) {
  RegularFile file(path);
  check_size(path, file.size(), most);
  std::string content;
  constexpr std::size_t kLeast = 4096;
  content.resize(std::max<std::size_t>(file.size() + 1, kLeast));
  std::size_t size = 0;
  while (const std::size_t got = file.read(content.data() + size, content.size() - size)) {
    size += got;
    check_size(path, size, most);
    if (size == content.size()) content.resize(2 * size);
  }
  content.resize(size);
  return content;
}

bool ends_in_line(const std::string& path) {
  const RegularFile file(path);
  char last = '\n';
  const auto end = static_cast<off_t>(file.size());
  return end > 0 && ::pread(file.descriptor(), &last, 1, end - 1) == 1 && last != '\n';
}

void check_size(const std::string& path, std::uint64_t bytes, std::uint64_t most) {
  if (bytes <= most) return;
  throw Error(path + ": is larger than " + size_text(most) + ", the most that is read");
}

}  // namespace hybrid
