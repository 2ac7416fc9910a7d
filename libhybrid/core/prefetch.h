// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Asks the processor to begin to load some bytes, which will be needed soon; `begin` may be null.
inline void prefetch(const void* begin, std::size_t bytes) {
  constexpr std::size_t kLine = 64;  // of the cache
  const char* from = static_cast<const char*>(begin);
  if (from == nullptr) return;
  for (std::size_t k = 0; k < bytes; k += kLine) __builtin_prefetch(from + k);
}

}  // namespace hybrid
