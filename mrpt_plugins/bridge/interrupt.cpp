// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/interrupt.h"

#include <fmt/format.h>

#include <array>
#include <csignal>

namespace hybrid {
namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

volatile std::sig_atomic_t noted = 0;

void note(int signal) {
  noted = signal;
  for (const int other : kSignals) {  // restores the default: the next signal ends the process
    struct sigaction action = {};
    if (::sigaction(other, nullptr, &action) != 0 || action.sa_handler != note) continue;
    action.sa_handler = SIG_DFL;
    ::sigaction(other, &action, nullptr);
  }
}

}  // namespace

void note_interrupts() {
  for (const int signal : kSignals) {
    struct sigaction action = {};
    if (::sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = note;
    action.sa_flags = SA_RESTART;
    ::sigaction(signal, &action, nullptr);
  }
}

int interrupted() {
  return noted;
}

const char* signal_name(int signal) {
  return signal == SIGINT ? "SIGINT" : signal == SIGTERM ? "SIGTERM" : "SIGHUP";
}

Interrupted::Interrupted(int signal)
    : Error(fmt::format("stopped by {}, nothing was written", signal_name(signal))),
      signal_(signal) {}

void throw_if_interrupted() {
  if (noted != 0) throw Interrupted(noted);
}

}  // namespace hybrid
