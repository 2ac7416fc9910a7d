// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <stdexcept>
#include <string>
#include <system_error>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Misuse or bad input; the message says what is wrong, where, and what to do about it.
/// Numerical trouble is not an error: solvers return a status.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message) : std::runtime_error(message) {}
};

/// The operating system refused something: a full disk, a missing permission. The message is
/// `what` and the reason.
class SystemError : public Error {
 public:
  /// `code` is a value of errno.
  SystemError(const std::string& what, int code)
      : Error(what + ": " + std::generic_category().message(code)), code_(code) {}
  int code() const { return code_; }

 private:
  int code_;
};

/// Settings that are invalid whatever the data.
class SettingsError : public Error {
 public:
  using Error::Error;
};

}  // namespace hybrid
