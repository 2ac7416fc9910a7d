// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// What the parser of a log told: up to 4 MiB in memory, and what came before that in a temporary
/// file without a name.
class ParsedLog {
 public:
  /// Up to `most` bytes.
  explicit ParsedLog(std::uint64_t most);

  /// Returns whether they are kept; if not, nothing of this log is any more.
  bool add(std::string_view bytes);
  /// Some bytes from there on, or none at the end. Throws Error if the system refuses.
  std::string read(std::uint64_t from) const;
  std::uint64_t size() const { return written_ + rest_.size(); }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  bool write_portion();

  std::uint64_t most_;
  bool is_kept_ = true;
  std::unique_ptr<std::FILE, Close> file_;  // null: all is in memory
  std::uint64_t written_ = 0;               // into it
  std::string rest_;
};

/// Logs that were read to their end, so that one which is read several times is parsed but once: up
/// to 1 GiB of all together, and no log that is larger than what is left.
class ParsedLogs {
 public:
  /// The log of that name, null where it is not here.
  std::shared_ptr<const ParsedLog> find(const std::string& name) const;
  /// A log to fill, null where one of so many bytes has no room.
  std::shared_ptr<ParsedLog> begin(std::uint64_t bytes) const;
  /// Keeps one that is whole.
  void keep(const std::string& name, std::shared_ptr<const ParsedLog> log);

 private:
  std::map<std::string, std::shared_ptr<const ParsedLog>> logs_;
  std::uint64_t left_ = std::uint64_t{1} << 30;
};

}  // namespace hybrid
