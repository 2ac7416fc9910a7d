// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "mrpt_plugins/output/summary.h"

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

}  // namespace hybrid
