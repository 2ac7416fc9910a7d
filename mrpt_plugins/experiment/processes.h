// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace hybrid {

/// How the process of a task ended.
struct ProcessEnd {
  enum class Kind { kDone, kThrew, kTimeout, kCrashed };

  Kind kind = Kind::kDone;
  std::string text;  ///< what the task returned, or what went wrong
};

/// Runs tasks 0 .. count - 1, each in a process of its own and at most `jobs` at a time, so that
/// none can take the others down. A task returns a text; one that runs longer than `time_limit`
/// seconds is ended. `done` is called in this process as tasks end, in whatever order. Processes
/// end when this one does. Call it while this process has one thread. Throws Error where no process
/// can be made.
void run_processes(std::size_t count, int jobs, double time_limit,
                   const std::function<std::string(std::size_t)>& task,
                   const std::function<void(std::size_t, const ProcessEnd&)>& done);

}  // namespace hybrid
