// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "libhybrid/core/error.h"

namespace HYBRID_API hybrid {

/// A task could not be done for a reason that lies in the machine, such as a full disk: it may well
/// be done another time.
class MachineFault : public Error {
 public:
  using Error::Error;
};

/// Whether a value of errno tells of such a reason: no space, no memory, no process, a broken disk.
bool is_machine_fault(int code);
/// The same of a message of one of our programs.
bool is_machine_fault(const std::string& message);
/// Whether a signal comes from outside of a process (SIGKILL, as of a system without memory,
/// SIGTERM) and not from a fault of its own, as SIGSEGV does.
bool is_from_outside(int signal);

/// How the process of a task ended.
struct ProcessEnd {
  enum class Kind { kDone, kThrew, kTimeout, kCrashed };

  Kind kind = Kind::kDone;
  std::string text;      ///< what the task returned, or what went wrong
  bool machine = false;  ///< the machine is to blame: see MachineFault; or a process was ended from
                         ///< outside, or got less than most of its time on a processor
};

/// Runs tasks 0 .. count - 1, each in a process of its own and at most `jobs` at a time, so that
/// none can take the others down. A task returns a text; one that runs longer than `time_limit`
/// seconds is ended. `done` is called in this process as tasks end, in whatever order. Once `stop`
/// says so, those that run are ended without a word. Processes, and those that they start, end when
/// this one does. Call it while this process has one thread. Throws Error where no process can be
/// made.
void run_processes(std::size_t count, int jobs, double time_limit,
                   const std::function<std::string(std::size_t)>& task,
                   const std::function<void(std::size_t, const ProcessEnd&)>& done,
                   const std::function<bool()>& stop = {});

}  // namespace hybrid
