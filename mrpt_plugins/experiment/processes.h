// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "libhybrid/core/error.h"

namespace HYBRID_API hybrid {

/// A task failed by a fault of the machine, such as a full disk: it may succeed at another time.
class MachineFault : public Error {
 public:
  using Error::Error;
};

/// Whether a value of errno is such a fault: no space, no memory, no process, a broken disk.
bool is_machine_fault(int code);
/// Whether an error message of one of our programs reports such a fault.
bool is_machine_fault(const std::string& message);
/// Whether a signal comes from outside the process (SIGTERM; SIGKILL, as when memory runs out)
/// rather than from a fault of its own, such as SIGSEGV.
bool is_from_outside(int signal);

/// How the process of a task ended.
struct ProcessEnd {
  enum class Kind { kDone, kThrew, kTimeout, kCrashed };

  Kind kind = Kind::kDone;
  std::string text;      ///< text that the task returned, or the error message
  bool machine = false;  ///< fault of the machine (see MachineFault), signal from outside,
                         ///< or timeout with too little processor time
};

/// Runs tasks 0 .. count - 1, each in a process of its own and at most `jobs` at a time, so that a
/// crash of one does not affect the others. A task returns a text; it is killed after `time_limit`
/// seconds. `done` is called in this process as tasks end, in any order. Once `stop` returns true,
/// running tasks are killed without a call of `done`. The processes of tasks, and those that they
/// start, end with this process. Call it while this process has one thread. Throws Error if a
/// process cannot be created.
void run_processes(std::size_t count, int jobs, double time_limit,
                   const std::function<std::string(std::size_t)>& task,
                   const std::function<void(std::size_t, const ProcessEnd&)>& done,
                   const std::function<bool()>& stop = {});

}  // namespace hybrid
