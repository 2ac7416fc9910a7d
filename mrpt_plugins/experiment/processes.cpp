// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/processes.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <vector>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

using Clock = std::chrono::steady_clock;
using Task = std::function<std::string(std::size_t)>;

constexpr int kThrew = 3;  // exit code of a task that threw; its text is the reason

struct Running {
  std::size_t index = 0;
  pid_t pid = -1;
  int pipe = -1;
  Clock::time_point end;  // when it is to be ended
  std::string text;
};

void write_all(int file, const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t count = ::write(file, text.data() + at, text.size() - at);
    if (count < 0 && errno != EINTR) return;
    if (count > 0) at += static_cast<std::size_t>(count);
  }
}

[[noreturn]] void run_child(std::size_t index, const Task& task, int pipe, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  ::setpgid(0, 0);  // what the task starts goes with it
  int code = 0;
  std::string text;
  try {
    text = task(index);
  } catch (const std::exception& e) {
    text = e.what();
    code = kThrew;
  }
  write_all(pipe, text);
  ::_exit(code);
}

Running start(std::size_t index, const Task& task, double time_limit) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) throw Error(std::string("no pipe: ") + std::strerror(errno));
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid < 0) {
    ::close(ends[0]);
    ::close(ends[1]);
    throw Error(std::string("no process for a trial: ") + std::strerror(errno));
  }
  if (pid == 0) {
    ::close(ends[0]);
    run_child(index, task, ends[1], parent);
  }
  ::setpgid(pid, pid);
  ::close(ends[1]);
  Running running;
  running.index = index;
  running.pid = pid;
  running.pipe = ends[0];
  running.end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                   std::chrono::duration<double>(std::min(time_limit, 1e9)));
  return running;
}

/// Waits for the process and says how it ended.
ProcessEnd finish(Running& running, bool late) {
  if (late) ::kill(-running.pid, SIGKILL);
  int status = 0;
  while (::waitpid(running.pid, &status, 0) < 0 && errno == EINTR) {
  }
  ::kill(-running.pid, SIGKILL);  // what it may have started
  ::close(running.pipe);
  if (late) return {ProcessEnd::Kind::kTimeout, "ended after the time limit"};
  if (WIFSIGNALED(status)) {
    return {ProcessEnd::Kind::kCrashed, fmt::format("ended by signal {} ({})", WTERMSIG(status),
                                                    ::strsignal(WTERMSIG(status)))};
  }
  if (WEXITSTATUS(status) == kThrew) return {ProcessEnd::Kind::kThrew, running.text};
  if (WEXITSTATUS(status) != 0) {
    return {ProcessEnd::Kind::kCrashed, fmt::format("ended with code {}", WEXITSTATUS(status))};
  }
  return {ProcessEnd::Kind::kDone, running.text};
}

/// Reads what is there; false once the other end is closed.
bool read_some(Running& running) {
  std::array<char, 4096> buffer{};
  const ssize_t count = ::read(running.pipe, buffer.data(), buffer.size());
  if (count < 0) return errno == EINTR;
  running.text.append(buffer.data(), static_cast<std::size_t>(count));
  return count > 0;
}

int milliseconds_to_next_end(const std::vector<Running>& all) {
  Clock::time_point next = all.front().end;
  for (const Running& running : all) next = std::min(next, running.end);
  const auto wait = std::chrono::duration_cast<std::chrono::milliseconds>(next - Clock::now());
  return static_cast<int>(std::clamp<long long>(wait.count() + 1, 0, 60000));
}

}  // namespace

void run_processes(std::size_t count, int jobs, double time_limit, const Task& task,
                   const std::function<void(std::size_t, const ProcessEnd&)>& done) {
  std::vector<Running> all;
  std::size_t next = 0;
  try {
    while (next < count || !all.empty()) {
      while (next < count && all.size() < static_cast<std::size_t>(std::max(1, jobs))) {
        all.push_back(start(next, task, time_limit));
        ++next;
      }
      std::vector<pollfd> polled;
      for (const Running& running : all) polled.push_back({running.pipe, POLLIN, 0});
      ::poll(polled.data(), polled.size(), milliseconds_to_next_end(all));
      for (std::size_t i = all.size(); i-- > 0;) {
        const bool closed = polled[i].revents != 0 && !read_some(all[i]);
        const bool late = !closed && Clock::now() >= all[i].end;
        if (!closed && !late) continue;
        Running ended = std::move(all[i]);
        all.erase(all.begin() + static_cast<std::ptrdiff_t>(i));
        const ProcessEnd end = finish(ended, late);
        done(ended.index, end);
      }
    }
  } catch (...) {
    for (Running& running : all) finish(running, true);
    throw;
  }
}

}  // namespace hybrid
