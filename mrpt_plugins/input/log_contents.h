// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>

#include "mrpt_plugins/input/keyframe_source.h"

namespace HYBRID_API hybrid {

/// Counts of detections of landmarks by their content.
struct DetectionCounts {
  std::size_t all = 0;
  std::size_t identified = 0;  ///< with a landmark id
  std::size_t classified = 0;  ///< by a sensor with classes

  bool mostly_identified() const { return 2 * identified > all; }
  bool mostly_classified() const { return 2 * classified > all; }
};

/// The content of a log by which plugins are chosen.
struct LogContents {
  /// Observations by class, without namespace.
  std::map<std::string, std::size_t> observations;
  /// The usable detections of CObservationBearingRange and CObservationClassedBearingRange.
  DetectionCounts with_range, without_range;
  std::size_t scans = 0;  ///< usable planar laser scans
  std::size_t steps = 0;

  /// No detection has an id that can be used.
  void forget_ids() { with_range.identified = without_range.identified = 0; }

  /// Counts those of another log as well.
  void add(const LogContents& other);
};

/// Sees every step of a log with the usable detections in it.
using StepWatcher = std::function<void(const LogStep&, const std::vector<DetectionFrame>&)>;

/// Reads the whole log. Measurements that are unusable by `options` do not count; of a damaged log,
/// the readable part counts. Throws Error if it cannot be opened, Interrupted on a signal.
LogContents read_contents(const std::string& rawlog, const SourceOptions& options,
                          const StepWatcher& watcher = {});

}  // namespace hybrid
