// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <mrpt/version.h>

#include <string>

#include "tests/support/run_shell.h"

namespace hybrid {

/// Why MRPT's own program cannot load our plugin; empty where it can.
inline std::string why_rawlog_edit_cannot() {
#ifdef __SANITIZE_ADDRESS__
  return "a sanitised plugin does not load into MRPT's own program";
#endif
  const std::string version = run_shell("rawlog-edit --version 2>&1").text;
  if (version.find("not found") != std::string::npos) {
    return "rawlog-edit (package mrpt-apps) is not installed";
  }
  if (MRPT_VERSION >= 0x30000 && version.find("MRPT 2.") != std::string::npos) {
    return "rawlog-edit is that of MRPT 2, the plugin is one of MRPT 3";
  }
  return "";
}

}  // namespace hybrid
