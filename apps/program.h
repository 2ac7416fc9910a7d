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

/// Runs a program: returns the exit code of `body` or, where that throws or runs out of memory in
/// what must not throw, tells why on standard error and returns the code of a failure or an
/// interrupt. Where a standard file is closed,
/// /dev/null takes its place, so that no file of a result gets its number and what is printed. A
/// reader of what is printed that goes away ends nothing.
int run_program(const std::string& name, const std::function<int()>& body);

/// Fixes the exit code once the result is written: a later failure, such as one in printing
/// messages, does not change it. Returns the code.
int settle(int exit_code);

/// Prints to a file, to standard output or to standard error, as far as that can be written.
template <class... Args>
void print_to(std::FILE* file, fmt::format_string<Args...> format, const Args&... args) {
  std::fputs(fmt::format(format, args...).c_str(), file);
}
template <class... Args>
void say(fmt::format_string<Args...> format, const Args&... args) {
  print_to(stdout, format, args...);
}
template <class... Args>
void complain(fmt::format_string<Args...> format, const Args&... args) {
  print_to(stderr, format, args...);
}

/// Prints warnings on standard error.
void warn_of(const std::vector<std::string>& warnings);

/// Prints warnings about the input files on standard error.
void warn_of_inputs(const Provenance& provenance);

}  // namespace hybrid
