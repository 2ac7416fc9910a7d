// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/bridge/provenance.h"

namespace hybrid {

/// Runs a program and returns the exit code of `body`. If `body` throws, or memory runs out where
/// nothing may be thrown, prints the reason on standard error and returns the code of a failure or
/// an interrupt. Closed standard files are opened as /dev/null, so that no file of a result gets
/// their numbers.
int run_program(const std::string& name, const std::function<int()>& body);

/// Fixes the exit code once the result is written: a later failure, such as one in printing
/// messages, does not change it. Returns the code.
int settle(int exit_code);

/// Prints to standard output or standard error, ignoring write errors.
template <class... Args>
void say(fmt::format_string<Args...> format, const Args&... args) {
  std::fputs(fmt::format(format, args...).c_str(), stdout);
}
template <class... Args>
void complain(fmt::format_string<Args...> format, const Args&... args) {
  std::fputs(fmt::format(format, args...).c_str(), stderr);
}

/// Prints warnings on standard error.
void warn_of(const std::vector<std::string>& warnings);

/// Prints warnings about the input files on standard error.
void warn_of_inputs(const Provenance& provenance);

}  // namespace hybrid
