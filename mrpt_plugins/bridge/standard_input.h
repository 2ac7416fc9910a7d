// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// The path that stands for standard input, where a log may come from while it is written.
inline constexpr const char* kStandardInput = "-";

inline bool is_standard_input(const std::string& path) {
  return path == kStandardInput;
}

/// A path as messages name it.
inline std::string shown_path(const std::string& path) {
  return is_standard_input(path) ? "standard input" : path;
}

}  // namespace hybrid
