// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A library that throws while it is loaded.

#include <stdexcept>

namespace {

struct Throws {
  Throws() { throw std::runtime_error("no licence"); }
};
const Throws kThrows;

}  // namespace
