// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A library that needs a function which nobody has.

int found_nowhere();

int call_it() {
  return found_nowhere();
}
