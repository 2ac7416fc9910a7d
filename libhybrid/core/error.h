// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <stdexcept>
#include <string>

namespace hybrid {

/// Misuse or bad input; the message says what is wrong, where, and what to do about it.
/// Numerical trouble is not an error: solvers return a status.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message) : std::runtime_error(message) {}
};

}  // namespace hybrid
