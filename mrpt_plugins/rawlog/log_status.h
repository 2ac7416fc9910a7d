// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

enum class LogStatus : std::uint8_t {
  kReading,            ///< Not at the end yet.
  kComplete,           ///< Read to the end, nothing wrong.
  kEmpty,              ///< The file holds no object.
  kNotARawlog,         ///< Not even the first object can be read.
  kTruncated,          ///< The file ends inside an object or inside the compressed stream.
  kCorrupt,            ///< An object cannot be read, or a checksum is wrong.
  kUnregisteredClass,  ///< An object of a class this program does not know.
  kTooLarge,           ///< Memory, time or size beyond the limits.
};

/// "complete", "empty", "not a rawlog", ...
const char* to_string(LogStatus status);

}  // namespace hybrid
