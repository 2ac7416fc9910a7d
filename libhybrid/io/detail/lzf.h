// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/io/text_reader.h"

namespace hybrid {

/// The bytes that follow the lines read, as PCD compresses them: two numbers of 32 bits, the sizes
/// compressed and uncompressed, then blocks of LZF. Throws Error if the file ends early, or the
/// blocks do not give that size. Takes memory as the blocks come, whatever the sizes say.
std::string read_lzf(TextReader& data);

}  // namespace hybrid
