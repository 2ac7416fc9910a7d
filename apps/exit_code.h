// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

namespace hybrid {

/// Exit codes of the programs. A result that is partial, empty or interrupted says so in the
/// `status` of its summary.json.
enum ExitCode {
  kExitOk = 0,
  kExitFailure = 1,       ///< nothing was written
  kExitPartial = 2,       ///< a partial or empty result was written; --help of each says when
  kExitInterrupted = 128  ///< plus the signal, as shells count: 130 SIGINT, 143 SIGTERM, 129 SIGHUP
};

}  // namespace hybrid
