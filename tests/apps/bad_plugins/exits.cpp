// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A library that ends the process while it is loaded.

#include <cstdlib>

namespace {

struct Exits {
  Exits() { std::exit(0); }
};
const Exits kExits;

}  // namespace
