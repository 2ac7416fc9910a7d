// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/parser_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "libhybrid/core/error.h"
#include "libhybrid/io/folders.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/rawlog/parser_main.h"

namespace hybrid {
namespace {

[[noreturn]] void fail() {
  throw Error(fmt::format("a process to parse a log: {}", std::strerror(errno)));
}

void expect_interrupted() {
  if (errno != EINTR && errno != EAGAIN) fail();
}

/// A descriptor that does not meet those of the process that gets it, and that no other gets.
int moved_up(int descriptor) {
  constexpr int kLeast = 10;
  const int moved = ::fcntl(descriptor, F_DUPFD_CLOEXEC, kLeast);
  if (moved < 0) fail();
  return moved;
}

/// Whether a fork cannot inherit a lock that another thread holds. Valgrind would follow a fork and
/// could not go on in it.
bool may_fork() {
  const char* preloaded = std::getenv("LD_PRELOAD");
  if (preloaded != nullptr && std::strstr(preloaded, "vgpreload") != nullptr) return false;
  const char* threads = "/proc/self/task";
  return name_exists(threads) && entries_of(threads).size() == 1;
}

struct Ends {
  int file, pipe;
};

pid_t fork_process(const Ends& ends, const ProcessTask& task) {
  const pid_t process = ::fork();
  if (process != 0) return process;
  ::setpgid(0, 0);
  const int null = ::open("/dev/null", O_RDWR);
  for (const int standard : {0, 1, 2}) ::dup2(null, standard);
  ::dup2(ends.file, kLogDescriptor);
  ::dup2(ends.pipe, kPipeDescriptor);
  ::_exit(task.run());
}

/// Attributes and actions of a program to start, freed at the end.
struct SpawnPlan {
  SpawnPlan() {
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawnattr_init(&attributes);
  }
  ~SpawnPlan() {
    ::posix_spawn_file_actions_destroy(&actions);
    ::posix_spawnattr_destroy(&attributes);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;

  posix_spawn_file_actions_t actions{};
  posix_spawnattr_t attributes{};
};

pid_t spawn_process(const Ends& ends, std::vector<std::string> arguments) {
  SpawnPlan plan;
  for (const int standard : {0, 1, 2}) {
    ::posix_spawn_file_actions_addopen(&plan.actions, standard, "/dev/null", O_RDWR, 0);
  }
  ::posix_spawn_file_actions_adddup2(&plan.actions, ends.file, kLogDescriptor);
  ::posix_spawn_file_actions_adddup2(&plan.actions, ends.pipe, kPipeDescriptor);
  ::posix_spawnattr_setflags(&plan.attributes, POSIX_SPAWN_SETPGROUP);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_t process = -1;
  errno = ::posix_spawn(&process, argv[0], &plan.actions, &plan.attributes, argv.data(), environ);
  if (errno != 0) throw Error(fmt::format("{}: {}", arguments[0], std::strerror(errno)));
  return process;
}

/// Closes a descriptor at the end of a scope.
struct Closing {
  int descriptor;
  explicit Closing(int d) : descriptor(d) {}
  ~Closing() { ::close(descriptor); }
  Closing(const Closing&) = delete;
  Closing& operator=(const Closing&) = delete;
};

}  // namespace

ParserProcess::ParserProcess(int file, const ParserLimits& limits, const LogRequest& request,
                             const std::vector<std::string>& libraries)
    : file_(file) {
  start(file, {[&] { return parse_into_pipe(limits, request); },
               [&] { return reader_command(limits, request, libraries); }});
}

ParserProcess::ParserProcess(int input, const ProcessTask& task) {
  start(input, task);
}

void ParserProcess::start(int input, const ProcessTask& task) {
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) fail();
  pipe_ = pipe[0];
  const Closing low_write_end(pipe[1]);
  try {
    const Closing log(moved_up(input)), write_end(moved_up(pipe[1]));
    const Ends ends{log.descriptor, write_end.descriptor};
    process_ = may_fork() ? fork_process(ends, task) : spawn_process(ends, task.command());
    if (process_ < 0) fail();
  } catch (...) {
    ::close(pipe_);
    throw;
  }
}

ParserProcess::~ParserProcess() {
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    wait();
  }
  ::close(pipe_);
}

/// Whether the log has nothing to read now, nor an end.
bool ParserProcess::awaits_log() const {
  if (file_ < 0) return false;
  pollfd log{file_, POLLIN, 0};
  return ::poll(&log, 1, 0) == 0;
}

ParserProcess::Got ParserProcess::read(std::string& bytes, int seconds) {
  // Waits second by second, so that a stop of both processes counts as one second.
  for (int second = 0; second < seconds;) {
    pollfd polled{pipe_, POLLIN, 0};
    const int ready = ::poll(&polled, 1, 1000);
    if (ready < 0) expect_interrupted();
    if (ready <= 0 && awaits_log()) {
      throw_if_interrupted();
    } else if (ready == 0) {
      ++second;
    }
    if (ready <= 0) continue;
    constexpr std::size_t kMost = std::size_t{1} << 16;
    bytes.resize(kMost);
    const ssize_t got = ::read(pipe_, bytes.data(), bytes.size());
    if (got < 0) expect_interrupted();
    if (got < 0) continue;
    bytes.resize(static_cast<std::size_t>(got));
    return got > 0 ? Got::kBytes : Got::kEnd;
  }
  return Got::kNothing;
}

ParserProcess::Exit ParserProcess::wait() {
  int status = 0;
  pid_t ended = -1;
  do {
    ended = ::waitpid(process_, &status, 0);
  } while (ended < 0 && errno == EINTR);
  process_ = -1;
  if (ended < 0) return Exit::kCrashed;
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) return Exit::kOutOfTime;
  if (!WIFEXITED(status)) return Exit::kCrashed;
  if (WEXITSTATUS(status) == kOutOfMemoryCode) return Exit::kOutOfMemory;
  return WEXITSTATUS(status) == 0 ? Exit::kDone : Exit::kCrashed;
}

}  // namespace hybrid
