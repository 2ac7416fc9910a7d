// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <fmt/format.h>

#include <string>

#include "libhybrid/methods/robust_methods.h"

namespace hybrid {

/// Names and meanings of the robust methods, one per line, for --help.
inline std::string method_list() {
  std::string text;
  for (const RobustMethod& method : robust_methods()) {
    text += fmt::format("  {:<23}{}\n", method.name, method.meaning);
  }
  return text;
}

}  // namespace hybrid
