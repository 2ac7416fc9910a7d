// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "mrpt_plugins/input/keyframe_source.h"

namespace HYBRID_API hybrid {

/// Detections of landmarks, by what is known of them.
struct DetectionCounts {
  std::size_t all = 0;
  std::size_t identified = 0;  ///< with an id of the landmark
  std::size_t classified = 0;  ///< by a sensor that names classes

  bool mostly_identified() const { return 2 * identified > all; }
  bool mostly_classified() const { return 2 * classified > all; }
};

/// What a log holds, as far as plugins are chosen by it.
struct LogContents {
  /// Observations by class, without namespace.
  std::map<std::string, std::size_t> observations;
  /// The usable detections of CObservationBearingRange and CObservationClassedBearingRange.
  DetectionCounts with_range, without_range;

  /// Counts those of another log as well.
  void add(const LogContents& other);
};

/// Reads the whole log. What is not usable by `options` does not count, and of a damaged log the
/// sound part does. Throws Error if it cannot be opened, Interrupted on a signal.
LogContents read_contents(const std::string& rawlog, const SourceOptions& options);

}  // namespace hybrid
