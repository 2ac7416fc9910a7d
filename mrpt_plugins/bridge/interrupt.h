// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/core/error.h"

namespace HYBRID_API hybrid {

/// From now on the first SIGINT, SIGTERM or SIGHUP is only noted, for interrupted() to tell; the
/// second one ends the process at once. A signal that this process was started to ignore, as by
/// nohup, stays ignored. Only for programs that ask often enough.
void note_interrupts();

/// The signal that was noted, or 0.
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

/// Throws Interrupted once a signal was noted.
void throw_if_interrupted();

}  // namespace hybrid
