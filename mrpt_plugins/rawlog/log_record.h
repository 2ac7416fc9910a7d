// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "mrpt_plugins/rawlog/asked_classes.h"
#include "mrpt_plugins/rawlog/log_object.h"
#include "mrpt_plugins/rawlog/log_status.h"

namespace HYBRID_API hybrid {

/// An object of this class, or an entry of this class in it, is about to be parsed.
struct ParsingClass {
  std::string name;
};

/// The log is at its end, or nothing more can be read.
struct LogEnd {
  LogStatus status = LogStatus::kComplete;
  std::string reason;  ///< empty if complete
  bool has_trailing_bytes = false;
};

/// The process that parses has started; `is_confined` tells whether system calls are filtered.
struct ParserStarted {
  bool is_confined = false;
};

/// What the process that parses a log tells, in order.
using LogRecord = std::variant<ParserStarted, ParsingClass, LogObject, LogEnd>;

/// A record as bytes: their number, what it is, and its content. Throws Error for an observation
/// that is too large, and what MRPT throws.
std::string to_bytes(const LogRecord& record, const AskedClasses& asked);

/// Cuts bytes that come in any portions into records, and reads them. The bytes may be anything:
/// what is not a record throws Error, and no more memory is used than there are bytes.
class RecordReader {
 public:
  /// Records of more than `most` bytes are refused.
  RecordReader(const AskedClasses& asked, std::uint64_t most) : asked_(asked), most_(most) {}

  void add(std::string_view bytes);
  /// The next record, if all of it is there.
  std::optional<LogRecord> next();

 private:
  AskedClasses asked_;
  std::uint64_t most_;
  std::string bytes_;
  std::size_t used_ = 0;  // of them
};

}  // namespace hybrid
