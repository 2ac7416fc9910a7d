// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/program.h"

#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>

#include "apps/exit_code.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/drawing/photograph.h"

namespace hybrid {
namespace {

void open_standard_files() {
  for (int file = STDIN_FILENO; file <= STDERR_FILENO; ++file) {
    if (::fcntl(file, F_GETFD) >= 0) continue;
    ::open("/dev/null", O_RDWR);  // opens the lowest free descriptor, which is this one
  }
}

std::string program;
int outcome = kExitFailure;
std::terminate_handler end_otherwise = nullptr;

/// Allocates nothing, since memory may have run out.
int failed(const char* why) {
  std::fprintf(stderr, "%s: %s\n", program.c_str(), why);
  return outcome;
}

/// Terminate handler. Libraries also allocate in functions that must not throw, such as
/// destructors.
void end_without_memory() {
  try {
    if (const auto exception = std::current_exception()) std::rethrow_exception(exception);
  } catch (const std::bad_alloc&) {
    std::_Exit(failed("out of memory"));
  } catch (const std::exception& e) {  // as MRPT's of OpenGL
    if (std::strstr(e.what(), "out of memory") != nullptr) std::_Exit(failed("out of memory"));
  } catch (...) {
  }
  end_otherwise();
}

pid_t running = 0;  // this process, while main() runs

/// At exit(): whether main() has returned, or a library has ended the program. A process that was
/// forked to try a library may end.
void expect_end() {
  if (running != ::getpid()) return;
  std::fflush(stdout);
  std::_Exit(
      failed("a library has ended the program: a plugin, or one that it loads, calls exit()"));
}

/// Runs it; main() has the result of it.
int run_to_end(const std::function<int()>& body) {
  running = ::getpid();
  std::atexit(expect_end);
  struct End {
    ~End() { running = 0; }
  } const end;
  return body();
}

}  // namespace

int settle(int exit_code) {
  return outcome = exit_code;
}

void warn_of(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) complain("{}: warning: {}\n", program, warning);
}

void warn_of_inputs(const Provenance& provenance) {
  for (const Provenance::Input& input : provenance.inputs) {
    if (input.warning.empty()) continue;
    complain("{}: warning: {}: {}\n", program, input.path, input.warning);
  }
}

int run_program(const std::string& name, const std::function<int()>& body) {
  program = name;
  open_standard_files();
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);  // so that a limit on the size of files is an error of writing
  end_otherwise = std::set_terminate(end_without_memory);
  expect_bad_alloc_of_opencv();
  try {
    return run_to_end(body);
  } catch (const Interrupted& e) {
    if (outcome == kExitFailure) outcome = kExitInterrupted + e.signal();
    return failed(e.what());
  } catch (const std::bad_alloc&) {
    return failed("out of memory");
  } catch (const std::exception& e) {
    return failed(e.what());
  } catch (...) {
    return failed("an exception of unknown type");
  }
}

}  // namespace hybrid
