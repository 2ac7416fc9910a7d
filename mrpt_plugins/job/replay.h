// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <functional>

#include "mrpt_plugins/job/replay_outcome.h"
#include "mrpt_plugins/settings/replay_request.h"

namespace HYBRID_API hybrid {

/// Maps a log: reads INI, log and truth, feeds keyframe after keyframe to the mapper, and writes
/// trajectories, landmarks, pictures and summary.json into the folder asked for, all of them or
/// none. A log from standard input is read once, as it comes: what would read it before is an error
/// that says what to give instead. Once a signal was noted (see interrupted()) it ends after the
/// keyframe under way with a partial result. `progress` is called after every keyframe; `published`
/// once the files are there, before anything else may fail. Throws Error, which names file, section
/// or key, where there is nothing to write.
ReplayOutcome replay(const ReplayRequest& request,
                     const std::function<void(const ReplayProgress&)>& progress = {},
                     const std::function<void(const ReplayOutcome&)>& published = {});

}  // namespace hybrid
