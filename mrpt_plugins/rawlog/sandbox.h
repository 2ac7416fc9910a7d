// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <optional>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// What a process that parses a log may use, from the size of the file.
struct ParserLimits {
  std::uint64_t memory = 0;   ///< beyond what it has when it starts [bytes]
  std::uint64_t seconds = 0;  ///< of processor time; 0: any
};

/// 256 MiB and sixteen times the file, up to 4 GiB: one object at a time is in memory, and MRPT's
/// take up to some ten times their bytes in the file. 20 s and one more for every 64 KiB, which is
/// a hundredth of the usual speed. What comes without an end in sight may have the largest objects,
/// and all the time it takes.
ParserLimits parser_limits(std::optional<std::uint64_t> file_bytes);

/// Takes from this process, for good, all that parsing does not need: memory and time beyond the
/// limits, core dumps, opening anything, and all system calls but those for memory, for reading and
/// writing what is open, and for ending. Returns whether system calls are filtered: a kernel may
/// have no seccomp, and then the limits alone hold.
bool confine_process(const ParserLimits& limits);

}  // namespace hybrid
