// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

namespace hybrid {

/// Exit codes of the programs; --help of each says what is partial.
enum ExitCode { kExitOk = 0, kExitFailure = 1, kExitPartial = 2 };

}  // namespace hybrid
