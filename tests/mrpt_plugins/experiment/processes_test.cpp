// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/processes.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <ctime>
#include <fstream>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

namespace hybrid {
namespace {

std::vector<ProcessEnd> run(std::size_t count, int jobs, double limit,
                            const std::function<std::string(std::size_t)>& task) {
  std::vector<ProcessEnd> ends(count);
  std::size_t calls = 0;
  run_processes(count, jobs, limit, task, [&](std::size_t i, const ProcessEnd& end) {
    ends.at(i) = end;
    ++calls;
  });
  EXPECT_EQ(calls, count);
  return ends;
}

TEST(Processes, ReturnWhatTasksSay) {
  const auto ends = run(7, 3, 60, [](std::size_t i) { return std::string(20000 * i, 'x'); });
  for (std::size_t i = 0; i < ends.size(); ++i) {
    EXPECT_EQ(ends[i].kind, ProcessEnd::Kind::kDone);
    EXPECT_EQ(ends[i].text.size(), 20000 * i);
  }
  run(0, 2, 60, [](std::size_t) { return std::string(); });
}

TEST(Processes, OneThatFailsLeavesTheOthersAlone) {
  const auto ends = run(4, 2, 0.5, [](std::size_t i) {
    if (i == 1) throw std::runtime_error("no such thing");
    if (i == 2) ::raise(SIGSEGV);
    while (i == 3) ::pause();
    return std::string("well");
  });
  EXPECT_EQ(ends[0].kind, ProcessEnd::Kind::kDone);
  EXPECT_EQ(ends[1].kind, ProcessEnd::Kind::kThrew);
  EXPECT_EQ(ends[1].text, "no such thing");
  EXPECT_NE(ends[2].kind, ProcessEnd::Kind::kDone);
  EXPECT_EQ(ends[3].kind, ProcessEnd::Kind::kTimeout);
}

TEST(Processes, TellFaultsOfTheMachineFromThoseOfTheTask) {
  const auto ends = run(9, 2, 1.0, [](std::size_t i) {
    if (i == 0) throw MachineFault("somebody else");
    if (i == 1) throw SystemError("cannot write 'f'", ENOSPC);
    if (i == 2) throw std::bad_alloc();
    if (i == 3) ::raise(SIGKILL);
    while (i == 4) ::pause();  // gets no time on a processor
    if (i == 5) throw SystemError("cannot read 'f'", ENOENT);
    if (i == 6) ::raise(SIGSEGV);
    if (i == 7) throw std::runtime_error("no such thing");
    return std::string("well");
  });
  for (std::size_t i = 0; i < ends.size(); ++i) EXPECT_EQ(ends[i].machine, i < 5) << i;
  EXPECT_EQ(ends[2].text, "out of memory");
}

TEST(Processes, MessagesOfOurProgramsTellFaultsOfTheMachine) {
  EXPECT_TRUE(is_machine_fault(SystemError("cannot write 'f'", ENOSPC).what()));
  EXPECT_TRUE(is_machine_fault("hybrid-replay: out of memory"));
  EXPECT_FALSE(is_machine_fault(SystemError("cannot read 'f'", ENOENT).what()));
  EXPECT_FALSE(is_machine_fault("the factors do not determine x7"));
}

TEST(Processes, StopWhereAsked) {
  std::size_t ended = 0;
  run_processes(
      100, 2, 60,
      [](std::size_t i) {
        while (i > 2) ::pause();
        return std::string();
      },
      [&](std::size_t, const ProcessEnd&) { ++ended; }, [&] { return ended >= 2; });
  EXPECT_LE(ended, 3U);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);  // none is left
}

/// Whether a process is there and no zombie.
bool lives(pid_t pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
  std::string id, name, state;
  return in >> id >> name >> state && state != "Z";
}

TEST(Processes, TasksEndWithTheProcessThatRanThem) {
  // The task tells its number. Then the process that ran it is killed, as by hand or for want of
  // memory.
  int ends[2] = {};
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t runner = ::fork();
  if (runner == 0) {
    run_processes(
        1, 1, 2000,
        [&](std::size_t) {
          const std::string number = std::to_string(::getpid());
          if (::write(ends[1], number.data(), number.size()) > 0) ::sleep(1000);
          return std::string();
        },
        [](std::size_t, const ProcessEnd&) {});
    ::_exit(0);
  }
  ::close(ends[1]);
  std::string text(16, '\0');
  const ssize_t count = ::read(ends[0], text.data(), text.size());
  ASSERT_GT(count, 0);
  const pid_t task = std::stoi(text);
  EXPECT_TRUE(lives(task));
  ::kill(runner, SIGKILL);
  ::waitpid(runner, nullptr, 0);
  // Signals arrive when the kernel gets to it; the loop ends with the test's own limit of time.
  while (lives(task)) ::usleep(1000);
}

TEST(Processes, AnErrorInDoneEndsThemAll) {
  EXPECT_THROW(run_processes(
                   3, 3, 60,
                   [](std::size_t i) {
                     while (i > 0) ::pause();
                     return std::string();
                   },
                   [](std::size_t, const ProcessEnd&) { throw std::runtime_error("disk full"); }),
               std::runtime_error);
}

}  // namespace
}  // namespace hybrid
