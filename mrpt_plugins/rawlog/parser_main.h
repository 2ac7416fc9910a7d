// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/rawlog/log_object.h"
#include "mrpt_plugins/rawlog/sandbox.h"

namespace HYBRID_API hybrid {

/// What is open in a process that parses a log, beside /dev/null as the three standard descriptors.
inline constexpr int kLogDescriptor = 3, kPipeDescriptor = 4;

/// Exit code of a process that needs more memory than it may have.
inline constexpr int kOutOfMemoryCode = 12;

/// Confines this process, parses the log that is open and writes its records into the pipe. Returns
/// the exit code.
int parse_into_pipe(const ParserLimits& limits, const LogRequest& request);

/// Confines this process, and makes of the bytes of picture files, each behind its length (64
/// bits), small pictures of at most `width` pixels in a row: two numbers of 32 bits, columns and
/// rows, and three bytes for each pixel; 0 and 0 where the bytes are no picture. Of depth images,
/// at their own size, with two bytes for each pixel, where `width` is 0. Returns the exit code.
int decode_pictures(const ParserLimits& limits, int width);

/// Command line of the program hybrid-rawlog-reader, which stands beside the library of this
/// function. Throws Error where it is missing.
std::vector<std::string> reader_command(const ParserLimits& limits, const LogRequest& request,
                                        const std::vector<std::string>& libraries);

/// The same where it decodes pictures.
std::vector<std::string> decoder_command(const ParserLimits& limits, int width);

/// What that program does with its command line; returns the exit code.
int run_rawlog_reader(const std::vector<std::string>& command);

}  // namespace hybrid
