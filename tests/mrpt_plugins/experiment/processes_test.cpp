// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/processes.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>
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
