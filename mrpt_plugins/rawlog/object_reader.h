// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/rawlog/log_object.h"
#include "mrpt_plugins/rawlog/log_record.h"
#include "mrpt_plugins/rawlog/log_status.h"
#include "mrpt_plugins/rawlog/parsed_logs.h"
#include "mrpt_plugins/rawlog/parser_process.h"

namespace HYBRID_API hybrid {

/// What a rawlog is read from: a regular file, or standard input as it comes.
class LogInput {
 public:
  /// Throws Error as RegularFile does; of standard input, for a terminal or a folder.
  explicit LogInput(const std::string& path);

  /// As messages name it.
  const std::string& name() const { return name_; }
  int descriptor() const;
  /// Bytes; nothing where only the end of standard input will tell.
  std::optional<std::uint64_t> size() const;

 private:
  std::string name_;
  std::optional<RegularFile> file_;
};

/// The objects of a rawlog one after the other, each whole or not at all; plain, gzip or Zstandard.
/// Of standard input, each is given when its last byte has come.
///
/// MRPT's parsers believe what they read: a damaged log, let alone one made for it, can crash them,
/// take all memory, name files to open, or run code. So they see a log only in a process of its own
/// (parser_process.h, sandbox.h) that has the file, a pipe, limits on memory and time, and no other
/// file, program or network. The file is read once, in bounded memory, and what is sound up to the
/// first fault is given. Points that a log keeps in files beside it are read here. Where a request
/// has parsed logs, a file that is read again is taken from them.
///
/// What comes back is trusted no more than the file. Odometry and the observations that this
/// program knows are plain numbers, read by RecordReader; whoever takes over the other process can
/// make up any log, an endless one too, but not reach MRPT's parsers here. That holds but for the
/// classes that a request names, as plugins of users may: MRPT has serialised their objects anew
/// after it parsed them, so what a file alone holds never arrives as it is, but a process that was
/// taken over could send other bytes to the parser of exactly that class. The alternative, a form
/// of our own for every class of MRPT, would be larger than this program.
class ObjectReader {
 public:
  /// `libraries` define classes of objects in the log; they are loaded into this process already.
  /// Throws Error as LogInput does, and if a class of the request is not registered.
  explicit ObjectReader(const std::string& path, const LogRequest& request = {},
                        const std::vector<std::string>& libraries = {});

  /// The next object, or nothing at the end; status() then says why it is the end. Throws
  /// Interrupted where a signal comes while standard input keeps it waiting.
  std::optional<LogObject> next();

  LogStatus status() const { return status_; }
  /// One line for the user: what happened, at which object, what to do. Empty while reading and
  /// when complete.
  const std::string& message() const { return message_; }
  /// Objects read so far; a fault is "at object N" counted from 0.
  std::uint64_t objects() const { return objects_; }
  /// Fraction of the log read; nothing while the end of standard input is not known.
  std::optional<double> progress() const;
  /// What is odd about the file or the system and no fault of the log.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  std::optional<LogRecord> next_record();
  ParserProcess::Got read(std::string& bytes);
  void take(const LogRecord& record);
  void finish(LogStatus status, const std::string& why);
  void finish_early(bool is_silent);

  LogInput input_;
  AskedClasses asked_;
  ParserLimits limits_;
  RecordReader records_;
  std::optional<ParserProcess> process_;  // none where the log was parsed before
  std::shared_ptr<ParsedLogs> logs_;      // null: it is not kept
  std::string key_;                       // of this one in them
  std::shared_ptr<const ParsedLog> parsed_;
  std::uint64_t parsed_at_ = 0;  // bytes of parsed_ that were read
  std::shared_ptr<ParsedLog> keeping_;
  LogStatus status_ = LogStatus::kReading;
  std::string message_;
  std::uint64_t objects_ = 0;
  bool is_started_ = false;
  std::string parsing_;  // class
  std::vector<std::string> notes_;
};

}  // namespace hybrid
