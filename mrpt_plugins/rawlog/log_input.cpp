// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/log_input.h"

#include <sys/stat.h>
#include <unistd.h>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/standard_input.h"

namespace hybrid {

LogInput::LogInput(const std::string& path) : name_(shown_path(path)) {
  struct stat status {};
  if (!is_standard_input(path)) {
    if (::stat(path.c_str(), &status) == 0 && S_ISFIFO(status.st_mode)) {
      throw Error(path + ": is a pipe; it is read as standard input: --rawlog - <" + path);
    }
    file_.emplace(path);
    return;
  }
  if (::isatty(STDIN_FILENO) == 1) {
    throw Error(name_ + ": is a terminal; pipe a log into it, or name a file");
  }
  if (::fstat(STDIN_FILENO, &status) == 0 && S_ISDIR(status.st_mode)) {
    throw Error(name_ + ": is a folder, not a file");
  }
}

int LogInput::descriptor() const {
  return file_ ? file_->descriptor() : STDIN_FILENO;
}

std::optional<std::uint64_t> LogInput::size() const {
  return file_ ? std::make_optional(file_->size()) : std::nullopt;
}

}  // namespace hybrid
