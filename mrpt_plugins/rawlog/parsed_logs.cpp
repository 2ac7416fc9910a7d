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
namespace {

constexpr std::size_t kPortion = std::size_t{1} << 22;
constexpr std::size_t kMostRead = std::size_t{1} << 16;

}  // namespace

ParsedLog::ParsedLog(std::uint64_t most) : most_(most) {}

bool ParsedLog::add(std::string_view bytes) {
  is_kept_ = is_kept_ && bytes.size() <= most_ - size();
  if (is_kept_) rest_ += bytes;
  while (is_kept_ && rest_.size() >= kPortion) is_kept_ = write_portion();
  if (!is_kept_) {
    file_.reset();
    rest_ = {};
    written_ = 0;
  }
  return is_kept_;
}

/// Puts the first portion of what is in memory into the file. Returns whether it could.
bool ParsedLog::write_portion() {
  if (!file_) file_.reset(std::tmpfile());
  std::size_t put = 0;
  while (file_ && put < kPortion) {
    const ssize_t more = ::pwrite(::fileno(file_.get()), rest_.data() + put, kPortion - put,
                                  static_cast<off_t>(written_ + put));
    if (more <= 0 && errno == EINTR) continue;
    if (more <= 0) return false;
    put += static_cast<std::size_t>(more);
  }
  rest_.erase(0, put);
  written_ += put;
  return put > 0;
}

std::string ParsedLog::read(std::uint64_t from) const {
  if (from >= size()) return {};
  if (from >= written_) return rest_.substr(from - written_, kMostRead);
  std::string bytes(std::min<std::uint64_t>(kMostRead, written_ - from), '\0');
  ssize_t got = 0;
  do {
    got = ::pread(::fileno(file_.get()), bytes.data(), bytes.size(), static_cast<off_t>(from));
  } while (got < 0 && errno == EINTR);
  if (got <= 0) throw Error(std::string("a parsed log: ") + std::strerror(errno));
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
