// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A library that says that it was built for another version, and ends the process while it is
// loaded: its version is known before.

#include <cstdint>
#include <cstdlib>

extern "C" {
struct OtherAbi {
  std::uint32_t bytes = sizeof(OtherAbi);
  std::uint32_t version[3] = {99, 2, 1};
  std::uint32_t mrpt = 0x30102;
  std::uint32_t eigen[3] = {3, 4, 0};
  std::uint32_t alignment = 32;
};
extern const OtherAbi hybrid_plugin_abi;
const OtherAbi hybrid_plugin_abi;
}

namespace {

struct Crashes {
  Crashes() { std::abort(); }
};
const Crashes kCrashes;

}  // namespace
