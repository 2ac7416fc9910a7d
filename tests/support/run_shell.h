// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace hybrid {

struct Ran {
  int code = -1;     ///< 128 + signal if it crashed
  std::string text;  ///< standard output
};

/// Runs a command in a shell.
inline Ran run_shell(const std::string& command) {
  Ran ran;
  FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) ran.text += buffer.data();
  const int status = pclose(pipe);
  ran.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return ran;
}

}  // namespace hybrid
