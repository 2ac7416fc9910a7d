// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/processes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <new>
#include <system_error>
#include <vector>

#include "libhybrid/io/file_writer.h"

namespace hybrid {
namespace {

using Clock = std::chrono::steady_clock;
using Task = std::function<std::string(std::size_t)>;

constexpr int kThrew = 3;    // exit code of a task that threw an exception; its text is the message
constexpr int kMachine = 4;  // exit code of a task that failed by a fault of the machine
constexpr int kLongestWait = 200;    // ms between calls of `stop`
constexpr double kMostOfTime = 0.9;  // share of its wall time that a computing process is on a
                                     // processor

constexpr std::array kMachineFaults{ENOSPC, EDQUOT, EIO,    ENOMEM, EAGAIN,
                                    EMFILE, ENFILE, ENOLCK, ESTALE, EROFS};

struct Running {
  std::size_t index = 0;
  pid_t pid = -1;
  int pipe = -1;
  Clock::time_point end;  // time limit
  std::string text;
};

/// The text of the task, and its exit code.
std::pair<std::string, int> outcome(std::size_t index, const Task& task) {
  try {
    return {task(index), 0};
  } catch (const MachineFault& e) {
    return {e.what(), kMachine};
  } catch (const std::bad_alloc&) {
    return {"out of memory", kMachine};
  } catch (const SystemError& e) {
    return {e.what(), is_machine_fault(e.code()) ? kMachine : kThrew};
  } catch (const std::system_error& e) {
    return {e.what(), is_machine_fault(e.code().value()) ? kMachine : kThrew};
  } catch (const std::exception& e) {
    return {e.what(), kThrew};
  }
}

/// Lets a new process end when its parent ends, and by signals.
void obey(pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_DFL);
}

[[noreturn]] void run_child(std::size_t index, const Task& task, int pipe, pid_t parent) {
  obey(parent);
  ::setpgid(0, 0);  // processes that the task starts belong to its group
  const auto [text, code] = outcome(index, task);
  ::_exit(write_all(pipe, text) == 0 ? code : 1);
}

Running start(std::size_t index, const Task& task, double time_limit) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw SystemError("no pipe for a trial", errno);
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid < 0) {
    const int error = errno;
    ::close(ends[0]);
    ::close(ends[1]);
    throw SystemError("no process for a trial", error);
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

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// Waits for a process, or for one of group -pid if pid is negative; adds its processor time [s].
/// False if there is none.
bool wait_for(pid_t pid, int& status, double& processor) {
  rusage usage{};
  pid_t got = -1;
  while ((got = ::wait4(pid, &status, 0, &usage)) < 0 && errno == EINTR) {
  }
  if (got > 0) processor += seconds(usage.ru_utime) + seconds(usage.ru_stime);
  return got > 0;
}

std::string signal_text(int signal) {
  return fmt::format("ended by signal {} ({})", signal, ::strsignal(signal));
}

/// Waits for the process, kills the processes it started, and returns how it ended.
ProcessEnd finish(Running& running, bool late, double time_limit) {
  using Kind = ProcessEnd::Kind;
  if (late) ::kill(-running.pid, SIGKILL);
  int status = 0, ignored = 0;
  double processor = 0;
  wait_for(running.pid, status, processor);
  ::kill(-running.pid, SIGKILL);
  while (wait_for(-running.pid, ignored, processor)) {
  }
  ::close(running.pipe);
  if (late) {
    const bool starved = processor < kMostOfTime * time_limit;
    return {Kind::kTimeout,
            fmt::format("ended after {:g} s, of which it had {:.3g} s on a processor", time_limit,
                        processor),
            starved};
  }
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return {Kind::kCrashed, signal_text(signal), is_from_outside(signal)};
  }
  const int code = WEXITSTATUS(status);
  if (code == kThrew || code == kMachine) return {Kind::kThrew, running.text, code == kMachine};
  if (code != 0) return {Kind::kCrashed, fmt::format("ended with code {}", code), false};
  return {Kind::kDone, running.text, false};
}

/// Reads the available bytes; false once the other end is closed.
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
  return static_cast<int>(std::clamp<long long>(wait.count() + 1, 0, kLongestWait));
}

}  // namespace

bool is_machine_fault(int code) {
  return std::find(kMachineFaults.begin(), kMachineFaults.end(), code) != kMachineFaults.end();
}

bool is_machine_fault(const std::string& message) {
  const auto has = [&](const std::string& text) { return message.find(text) != std::string::npos; };
  return has("out of memory") || has(" is writing it") ||
         std::any_of(kMachineFaults.begin(), kMachineFaults.end(),
                     [&](int code) { return has(std::generic_category().message(code)); });
}

bool is_from_outside(int signal) {
  return signal == SIGKILL || signal == SIGTERM || signal == SIGINT || signal == SIGHUP ||
         signal == SIGQUIT || signal == SIGXCPU || signal == SIGXFSZ;
}

void run_processes(std::size_t count, int jobs, double time_limit, const Task& task,
                   const std::function<void(std::size_t, const ProcessEnd&)>& done,
                   const std::function<bool()>& stop) {
  // Orphaned processes of a task become children of this process, so that it can wait for them.
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  std::vector<Running> all;
  std::size_t next = 0;
  const auto end_all = [&] {
    for (Running& running : all) finish(running, true, time_limit);
    all.clear();
  };
  try {
    while ((next < count || !all.empty()) && !(stop && stop())) {
      while (next < count && all.size() < static_cast<std::size_t>(std::max(1, jobs))) {
        all.push_back(start(next, task, time_limit));
        ++next;
      }
      std::vector<pollfd> polled;
      for (const Running& running : all) polled.push_back({running.pipe, POLLIN, 0});
      if (::poll(polled.data(), polled.size(), milliseconds_to_next_end(all)) < 0) continue;
      for (std::size_t i = all.size(); i-- > 0;) {
        const bool closed = polled[i].revents != 0 && !read_some(all[i]);
        const bool late = !closed && Clock::now() >= all[i].end;
        if (!closed && !late) continue;
        Running ended = std::move(all[i]);
        all.erase(all.begin() + static_cast<std::ptrdiff_t>(i));
        const ProcessEnd end = finish(ended, late, time_limit);
        done(ended.index, end);
      }
    }
  } catch (...) {
    end_all();
    throw;
  }
  end_all();
}

}  // namespace hybrid
