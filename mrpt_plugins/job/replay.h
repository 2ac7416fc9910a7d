// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/settings/replay_request.h"

namespace HYBRID_API hybrid {

/// How far a replay is.
struct ReplayProgress {
  std::optional<double> fraction;  ///< of the log, where its size is known
  std::size_t keyframes = 0, landmarks = 0;
  double objective = 0;
  std::string line;  ///< the newest keyframe as JSON, where asked for
};

/// What a replay wrote.
struct ReplayOutcome {
  Summary summary;               ///< the content of summary.json
  std::filesystem::path folder;  ///< where the files are
  int signal = 0;                ///< that stopped it with keyframes left; 0: none did
};

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
