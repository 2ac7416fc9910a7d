// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/output_directory.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>

namespace hybrid {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw std::runtime_error(fmt::format("cannot write '{}': {}", path.string(), what));
}

void write_bytes(const std::string& path, std::string_view content) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) fail(path, std::strerror(errno));
  const bool written = std::fwrite(content.data(), 1, content.size(), file) == content.size() &&
                       std::fflush(file) == 0;
  const int write_error = errno;
  const bool closed = std::fclose(file) == 0;
  if (!written) fail(path, std::strerror(write_error));
  if (!closed) fail(path, std::strerror(errno));
}

/// Removes the temporary file unless it was renamed before.
class TemporaryFile {
 public:
  explicit TemporaryFile(fs::path path) : path_(std::move(path)) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

OutputDirectory::OutputDirectory(fs::path folder) : folder_(std::move(folder)) {
  if (folder_.empty()) throw std::runtime_error("the output folder has an empty name");
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error || !fs::is_directory(folder_)) {
    throw std::runtime_error(fmt::format("cannot create the output folder '{}': {}",
                                         folder_.string(),
                                         error ? error.message() : "a file of that name exists"));
  }
  const TemporaryFile probe(folder_ / fmt::format(".tmp-{}-probe", ::getpid()));
  write_bytes(probe.path().string(), "");
}

void OutputDirectory::write(const std::string& name, std::string_view content) const {
  save(name, [content](const std::string& path) { write_bytes(path, content); });
}

void OutputDirectory::save(const std::string& name,
                           const std::function<void(const std::string&)>& save) const {
  if (name.empty() || fs::path(name).filename() != name || name == "." || name == "..") {
    fail(folder_ / name, "not a plain file name");
  }
  const fs::path target = folder_ / name;
  const TemporaryFile temporary(folder_ / fmt::format(".tmp-{}-{}", ::getpid(), name));
  try {
    save(temporary.path().string());
  } catch (const std::exception& e) {
    fail(target, e.what());
  }
  std::error_code error;
  if (!fs::is_regular_file(temporary.path(), error)) fail(target, "nothing was written");
  fs::rename(temporary.path(), target, error);
  if (error) fail(target, error.message());
}

}  // namespace hybrid
