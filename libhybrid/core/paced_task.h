// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <memory>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Notes that the calling thread has done work of about so many multiplications. A paced task may
/// pause here. Not to be called where a lock is held, or in the body of a parallel loop.
void note_work(double multiplications);

/// All work that the calling thread has noted so far.
double noted_work();

/// A function that is run a little at a time, by the work that it notes and not by the clock, so
/// that it pauses at the same places in every run. It has a thread of its own, which runs only
/// while `advance` waits for it.
class HYBRID_API PacedTask {
 public:
  /// Does not begin yet.
  explicit PacedTask(std::function<void()> function);
  /// Ends the function where it has paused, by an exception that is not a std::exception.
  ~PacedTask();
  PacedTask(const PacedTask&) = delete;
  PacedTask& operator=(const PacedTask&) = delete;

  /// Goes on until the function has noted this much work, or all of it is done; returns whether it
  /// is. Throws what the function throws.
  bool advance(double multiplications);

 private:
  struct State;

  std::unique_ptr<State> state_;
};

}  // namespace hybrid
