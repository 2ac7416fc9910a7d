// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "tests/support/run_shell.h"

namespace hybrid {

/// Runs a program of the build with its arguments; `before` is what the shell reads before it. The
/// text is that of standard output and error.
inline Ran run_app(const std::string& command, const std::string& before = "") {
  return run_shell(before + HYBRID_BINARY_DIR "/bin/" + command + " 2>&1");
}

}  // namespace hybrid
