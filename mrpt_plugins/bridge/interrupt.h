// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/core/error.h"

namespace HYBRID_API hybrid {

/// Catches the first SIGINT, SIGTERM or SIGHUP, which interrupted() then returns; the second one
/// ends the process at once, and so does a first one that interrupted() has told nobody for 30 s,
/// as where a plugin waits for ever. A signal that was ignored when the process started, as under
/// nohup, stays ignored. Only for programs that poll interrupted() often.
void note_interrupts();

/// The signal that was caught, or 0.
int interrupted();

/// "SIGINT" and so on.
const char* signal_name(int signal);

/// A signal asked the program to stop, and nothing was written.
class Interrupted : public Error {
 public:
  explicit Interrupted(int signal);
  int signal() const { return signal_; }

 private:
  int signal_;
};

/// Throws Interrupted once a signal was caught.
void throw_if_interrupted();

}  // namespace hybrid
