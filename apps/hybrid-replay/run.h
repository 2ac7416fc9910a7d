// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "mrpt_plugins/settings/replay_request.h"

namespace hybrid {

/// Replays, with progress, and prints what came of it. Returns the exit code; throws on failure.
/// `strict`: where a run says of itself that it is wrong, the exit code is that of a partial
/// result.
int run(const ReplayRequest& request, bool strict);

}  // namespace hybrid
