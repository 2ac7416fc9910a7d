// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/parsed_logs.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "libhybrid/core/error.h"

namespace hybrid {

ParsedLog::ParsedLog(std::uint64_t most) : file_(std::tmpfile()), most_(most) {}

bool ParsedLog::add(std::string_view bytes) {
  if (!file_) return false;
  const bool fits = bytes.size() <= most_ - size_;
  while (fits && !bytes.empty()) {
    const ssize_t put =
        ::pwrite(::fileno(file_.get()), bytes.data(), bytes.size(), static_cast<off_t>(size_));
    if (put <= 0 && errno == EINTR) continue;
    if (put <= 0) break;
    size_ += static_cast<std::uint64_t>(put);
    bytes.remove_prefix(static_cast<std::size_t>(put));
  }
  if (!fits || !bytes.empty()) file_.reset();
  return file_ != nullptr;
}

std::string ParsedLog::read(std::uint64_t from) const {
  constexpr std::uint64_t kPortion = std::uint64_t{1} << 16;
  std::string bytes(std::min(kPortion, size_ - std::min(from, size_)), '\0');
  ssize_t got = 0;
  do {
    got = ::pread(::fileno(file_.get()), bytes.data(), bytes.size(), static_cast<off_t>(from));
  } while (got < 0 && errno == EINTR);
  if (got < 0) throw Error(std::string("a parsed log: ") + std::strerror(errno));
  bytes.resize(static_cast<std::size_t>(got));
  return bytes;
}

std::shared_ptr<const ParsedLog> ParsedLogs::find(const std::string& name) const {
  const auto log = logs_.find(name);
  return log == logs_.end() ? nullptr : log->second;
}

std::shared_ptr<ParsedLog> ParsedLogs::begin(std::uint64_t bytes) const {
  return bytes > left_ ? nullptr : std::make_shared<ParsedLog>(left_);
}

void ParsedLogs::keep(const std::string& name, std::shared_ptr<const ParsedLog> log) {
  if (log->size() > left_) return;
  if (logs_.emplace(name, log).second) left_ -= log->size();
}

}  // namespace hybrid
