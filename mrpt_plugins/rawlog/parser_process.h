// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

#include "mrpt_plugins/rawlog/log_object.h"
#include "mrpt_plugins/rawlog/sandbox.h"

namespace HYBRID_API hybrid {

/// What a process of its own does: as a fork of this one, or as a program with its command line.
struct ProcessTask {
  std::function<int()> run;  ///< Returns the exit code.
  std::function<std::vector<std::string>()> command;
};

/// A process of its own that parses a log and writes records (log_record.h) into a pipe.
///
/// A process that has a single thread forks, which takes a millisecond. Where there are more
/// threads, a fork could inherit a lock that nobody opens any more: then the program
/// hybrid-rawlog-reader is started, which takes 0.1 s. The process confines itself before it reads
/// the first byte of the log (sandbox.h). It belongs to no terminal, and ends when nobody reads its
/// pipe any more, so that it does not outlive the reader.
class ParserProcess {
 public:
  /// Parses what is open as `file`, which must stay open, from where it stands. `libraries` are
  /// loaded first by the program; a fork has them already. Throws Error if no process can be
  /// started.
  ParserProcess(int file, const ParserLimits& limits, const LogRequest& request,
                const std::vector<std::string>& libraries);
  /// Starts one that does something else with its input; all the time that read() waits counts.
  ParserProcess(int input, const ProcessTask& task);
  /// Ends the process.
  ~ParserProcess();
  ParserProcess(const ParserProcess&) = delete;
  ParserProcess& operator=(const ParserProcess&) = delete;

  enum class Got { kBytes, kEnd, kNothing };
  /// Puts what the process has written into `bytes`, and waits for it up to `seconds`; while `file`
  /// has nothing to read, as where it is a pipe of a slow writer, the time does not count. Throws
  /// Error if the system refuses, and then Interrupted on a signal.
  Got read(std::string& bytes, int seconds);

  /// How a process ended.
  enum class Exit { kDone, kOutOfMemory, kOutOfTime, kCrashed };
  /// Waits for the end of a process whose pipe is at its end.
  Exit wait();

 private:
  void start(int input, const ProcessTask& task);
  bool awaits_log() const;

  int file_ = -1;  // whose silence does not count; -1: none
  pid_t process_ = -1;
  int pipe_ = -1;
};

}  // namespace hybrid
