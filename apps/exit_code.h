// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

namespace hybrid {

/// Exit codes of the programs. A partial, empty or interrupted result has a matching `status` in
/// its summary.json.
enum ExitCode {
  kExitOk = 0,
  kExitFailure = 1,       ///< nothing was written
  kExitPartial = 2,       ///< a partial or empty result was written; see --help of each program
  kExitInterrupted = 128  ///< plus the signal, as in shells: 130 SIGINT, 143 SIGTERM, 129 SIGHUP
};

}  // namespace hybrid
