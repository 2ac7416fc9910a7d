// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// An edge of a graph by its vertices, from a line of a file.
struct VertexPair {
  std::uint64_t i = 0, j = 0;
  bool flag = true;
  std::size_t line = 0;  ///< of the file
};

/// Reads rows `i j`, or also `i j 0|1` if `flags`; a missing flag is 1. Throws Error
/// "file:line:column: what" for anything else; the file may have no rows.
std::vector<VertexPair> read_pairs(const std::string& path, bool flags);

}  // namespace hybrid
