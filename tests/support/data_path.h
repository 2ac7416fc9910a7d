// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdlib>
#include <string>

namespace hybrid::testing {

/// The path of a public data set, which may be missing: in $HYBRID_DATA_DIR, or else in the
/// configured folder.
inline std::string data_path(const std::string& name) {
  const char* environment = std::getenv("HYBRID_DATA_DIR");
  return std::string(environment != nullptr ? environment : HYBRID_DATA_DIR) + "/" + name;
}

}  // namespace hybrid::testing
