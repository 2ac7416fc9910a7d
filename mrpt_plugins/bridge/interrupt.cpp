// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/interrupt.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <csignal>

namespace hybrid {
namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

constexpr unsigned kPatience = 30;  // for somebody to ask for a signal [s]

volatile std::sig_atomic_t noted = 0;

/// Allocates nothing and takes no lock: the program may stand anywhere.
[[noreturn]] void give_up(int) {
  constexpr char kWhy[] =
      "a signal to stop was not noticed for 30 s, as where a plugin waits for something: ended "
      "without a result\n";
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, kWhy, sizeof(kWhy) - 1);
  ::_exit(128 + noted);
}

void note(int signal) {
  noted = signal;
  ::signal(SIGALRM, give_up);
  ::alarm(kPatience);
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
  if (noted != 0) ::alarm(0);
  return noted;
}

const char* signal_name(int signal) {
  return signal == SIGINT ? "SIGINT" : signal == SIGTERM ? "SIGTERM" : "SIGHUP";
}

Interrupted::Interrupted(int signal)
    : Error(fmt::format("stopped by {}, nothing was written", signal_name(signal))),
      signal_(signal) {}

void throw_if_interrupted() {
  if (const int signal = interrupted(); signal != 0) throw Interrupted(signal);
}

}  // namespace hybrid
